#include "nodes/supervisors.h"

#include <ros/console.h>

#include <sstream>
#include <stdexcept>
#include <utility>

#include "nodes/launching_process.h"
#include "nodes/remote_supervisor.h"

namespace tactile_clay::nodes {

std::set<std::string> requiredSupervisors(const std::string& text) {
  std::istringstream stream(text);
  std::set<std::string> words;
  for (std::string word; stream >> word;) {
    if (word != "roslaunch" && word != "master" && word != "none")
      throw std::runtime_error("supervisors: unknown '" + word +
                               "', expected roslaunch, master, both, or none");
    words.insert(word);
  }
  if (words.empty() || (words.count("none") > 0 && words.size() > 1))
    throw std::runtime_error("supervisors: '" + text + "', expected roslaunch, master, both, or none");
  return words;
}

Supervisors::Supervisors(const std::string& required) {
  const std::set<std::string> words = requiredSupervisors(required);
  const bool roslaunch = words.count("roslaunch") > 0;
  if (auto process = LaunchingProcess::find()) {
    const std::string server = process->server();
    watch("roslaunch", roslaunch, std::move(process));
    if (!server.empty()) watch("roslaunch of the other host", roslaunch, RemoteSupervisor::roslaunch(server));
  }
  watch("the master", words.count("master") > 0, RemoteSupervisor::master());
}

void Supervisors::watch(const std::string& name, bool required, std::unique_ptr<Supervisor> supervisor) {
  watched_.push_back({name, required, std::move(supervisor), ""});
}

std::string Supervisors::missing() {
  std::string first;
  for (Watched& watched : watched_) {
    const std::string line = watched.supervisor->missing();
    if (line != watched.told) {
      if (line.empty())
        ROS_WARN("%s is back", watched.name.c_str());
      else if (!watched.required)
        ROS_WARN("%s; the array goes on, as ~supervisors says", line.c_str());
      watched.told = line;
    }
    if (watched.required && first.empty()) first = line;
  }
  return first;
}

}  // namespace tactile_clay::nodes
