#include "rviz_plugins/service_calls.h"

#include <ros/ros.h>

#include <mutex>
#include <thread>
#include <utility>

namespace tactile_clay::rviz_plugins {

struct ServiceCalls::Shared {
  std::mutex mutex;
  std::vector<Answer> answers;
  bool busy = false;
  bool looking = false;  // at the rig
  Rig rig;
};

ServiceCalls::ServiceCalls() : shared_(std::make_shared<Shared>()) {}

bool ServiceCalls::start(const std::string& what, Call work) {
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    if (shared_->busy) return false;
    shared_->busy = true;
  }
  std::thread([shared = shared_, what, work = std::move(work)] {
    std::string answer;
    bool good = false;
    try {
      good = work(answer);
    } catch (const std::exception& error) {
      answer = error.what();
    }
    const std::lock_guard<std::mutex> lock(shared->mutex);
    shared->answers.push_back({what + ": " + answer, good});
    shared->busy = false;
  }).detach();
  return true;
}

std::vector<ServiceCalls::Answer> ServiceCalls::take() {
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  return std::exchange(shared_->answers, {});
}

ServiceCalls::Rig ServiceCalls::rig() const {
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  return shared_->rig;
}

void ServiceCalls::lookAtRig(const std::string& clay, const std::string& surface) {
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    if (shared_->looking) return;
    shared_->looking = true;
  }
  std::thread([shared = shared_, clay, surface] {
    Rig rig;
    ros::param::get(clay + "/scene", rig.scene);
    rig.has_undo = ros::service::exists(clay + "/undo", false);
    rig.has_export = ros::service::exists(surface + "/export", false);
    const std::lock_guard<std::mutex> lock(shared->mutex);
    shared->rig = rig;
    shared->looking = false;
  }).detach();
}

}  // namespace tactile_clay::rviz_plugins
