#pragma once

#include <ros/ros.h>
#include <rosgraph_msgs/Log.h>
#include <rviz/panel.h>
#include <std_msgs/Empty.h>
#include <tactile_clay/ArrayState.h>

#include <functional>
#include <string>

#include "rviz_plugins/parameter_window.h"
#include "rviz_plugins/quality_box.h"
#include "rviz_plugins/recording.h"
#include "rviz_plugins/service_calls.h"

class QGridLayout;
class QLabel;
class QLineEdit;
class QPushButton;

namespace tactile_clay::rviz_plugins {

/// The controls of an experimenter: a big stop of the array and its reset, the clay's reset, save, load and
/// undo, its surface as a mesh, its scene and quality, the live parameters of all nodes in a window, and
/// recording on and off, with keys that work wherever the focus is. The last line has the answers of
/// services. Undo and the meshes are not shown if the rig does not offer them.
class ExperimenterPanel : public rviz::Panel {
  Q_OBJECT
 public:
  explicit ExperimenterPanel(QWidget* parent = nullptr);
  ~ExperimenterPanel() override;

  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 private:
  struct Place {  // in the grid
    int row, column, width;
  };
  QPushButton* button(QGridLayout& grid, const Place& place, const QString& text, const QString& key,
                      const QString& help, const std::function<void()>& action);
  void addArray(QGridLayout& grid);
  void addClay(QGridLayout& grid);
  void addRecording(QGridLayout& grid);
  void addForm(QGridLayout& grid);
  void subscribeClay();
  void stop();
  void undo();
  void saveClay();
  void loadClay();
  void exportMesh(const QString& ending);
  void record();
  void lookAtRecording();
  void lookAtRig();
  std::string surface() const;
  void call(const std::string& what, ServiceCalls::Call work, const std::string& node = "");
  void change(const std::string& node, const LiveValue& value);
  void say(const QString& words, bool good);
  void look();

  ros::NodeHandle nh_;
  ros::Publisher stop_;
  ros::Subscriber state_, log_;  // their callbacks run in the thread that draws
  ArrayState::ConstPtr array_;
  ros::SteadyTime array_came_, looked_at_rig_;
  ServiceCalls calls_;
  std::string clay_name_;  // full name of the node that simulates the clay: the last one that is a name
  std::string newest_;     // file that was saved last
  std::string asked_;      // node that was asked for a value last
  std::string refusal_;    // why it changed nothing
  Recording recording_;
  ParameterWindow* parameters_;
  QLabel *array_line_, *answer_line_, *scene_line_, *record_line_;
  QualityBox* quality_;
  QPushButton *undo_, *record_, *stl_, *ply_;
  QLineEdit *folder_, *clay_;
};

}  // namespace tactile_clay::rviz_plugins
