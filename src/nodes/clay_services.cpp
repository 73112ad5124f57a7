#include "nodes/clay_services.h"

#include <cstdio>
#include <string>
#include <utility>

#include "clay/sculpture_file.h"
#include "nodes/file_service.h"

namespace tactile_clay::nodes {

ClayServices::ClayServices(ros::NodeHandle private_nh, std::shared_ptr<ClayRun> run)
    : run_(std::move(run)),
      reset_(private_nh.advertiseService("reset", &ClayServices::reset, this)),
      save_(private_nh.advertiseService("save", &ClayServices::save, this)),
      overwrite_(private_nh.advertiseService("overwrite", &ClayServices::overwrite, this)),
      load_(private_nh.advertiseService("load", &ClayServices::load, this)),
      undo_(private_nh.advertiseService("undo", &ClayServices::undo, this)) {}

bool ClayServices::reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  run_->reset();
  response.success = true;
  response.message = "scene '" + run_->scene().name + "' starts again";
  return true;
}

bool ClayServices::save(SculptureFile::Request& request, SculptureFile::Response& response) {
  return write(request.file, files::Existing::keep, response);
}

bool ClayServices::overwrite(SculptureFile::Request& request, SculptureFile::Response& response) {
  return write(request.file, files::Existing::replace, response);
}

bool ClayServices::write(const std::string& file, files::Existing existing,
                         SculptureFile::Response& response) {
  const clay::Sculpture sculpture = run_->sculpture();
  answer(response, [&] {
    requireAbsolute("sculpture", file);
    clay::save(sculpture, file, existing);
    return "scene '" + run_->scene().name + "' saved in " + file;
  });
  return true;
}

bool ClayServices::load(SculptureFile::Request& request, SculptureFile::Response& response) {
  answer(response, [&] {
    requireAbsolute("sculpture", request.file);
    run_->restore(clay::loadSculpture(request.file));
    return "scene '" + run_->scene().name + "' continues from " + request.file;
  });
  return true;
}

bool ClayServices::undo(Undo::Request& request, Undo::Response& response) {
  answer(response, [&] {
    const ClayRun::Undone undone = run_->undo(request.seconds);
    response.went_back = undone.went_back;
    char text[80];
    std::snprintf(text, sizeof text, "the clay is as it was %.2f s ago, at %.2f s", undone.went_back,
                  undone.time);
    return std::string(text);
  });
  return true;
}

}  // namespace tactile_clay::nodes
