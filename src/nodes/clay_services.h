#pragma once

#include <ros/ros.h>
#include <std_srvs/Trigger.h>
#include <tactile_clay/SculptureFile.h>
#include <tactile_clay/Undo.h>

#include <memory>
#include <string>

#include "files/output_file.h"
#include "nodes/clay_run.h"

namespace tactile_clay::nodes {

/// Services that save, load and replace the clay: `~reset` starts the scene again, `~save` writes the clay to
/// a new file, `~overwrite` to a file that may exist already, `~load` goes on from a file. `~undo` goes back
/// to a state of the last `~undo_seconds` (`clay::Keyframes`), also to a state before a reset or a load.
class ClayServices {
 public:
  ClayServices(ros::NodeHandle private_nh, std::shared_ptr<ClayRun> run);

 private:
  bool reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  bool save(SculptureFile::Request& request, SculptureFile::Response& response);
  bool overwrite(SculptureFile::Request& request, SculptureFile::Response& response);
  bool write(const std::string& file, files::Existing existing, SculptureFile::Response& response);
  bool load(SculptureFile::Request& request, SculptureFile::Response& response);
  bool undo(Undo::Request& request, Undo::Response& response);

  std::shared_ptr<ClayRun> run_;
  ros::ServiceServer reset_, save_, overwrite_, load_, undo_;
};

}  // namespace tactile_clay::nodes
