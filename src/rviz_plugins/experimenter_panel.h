#pragma once

#include <dynamic_reconfigure/Config.h>
#include <ros/ros.h>
#include <rviz/panel.h>
#include <std_msgs/Empty.h>
#include <tactile_clay/ArrayState.h>

#include <functional>
#include <memory>
#include <string>

class QComboBox;
class QLabel;
class QLineEdit;
class QProcess;
class QPushButton;

namespace tactile_clay::rviz_plugins {

/// What an experimenter needs at hand: a big stop of the array and its reset, the clay's reset, save and
/// load, its scene and quality, and recording on and off, with keys that work wherever the focus is. What
/// services answer is told in its last line. What the rig does not offer is not shown.
class ExperimenterPanel : public rviz::Panel {
  Q_OBJECT
 public:
  explicit ExperimenterPanel(QWidget* parent = nullptr);
  ~ExperimenterPanel() override;

  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 private:
  /// What calls of services and looks at the rig found, for the thread that draws.
  struct Answers;
  using Call = std::function<bool(std::string& answer)>;  // returns whether it succeeded

  QPushButton* button(const QString& text, const QString& key, const QString& help,
                      const std::function<void()>& action);
  void subscribeClay();
  void stop();
  void resetArray();
  void resetClay();
  void undo();
  void saveClay();
  void loadClay();
  void setQuality(const QString& quality);
  void record();
  void stopRecording();
  void recordingEnded(int code);
  void lookAtRecording();
  /// Asks the master for what no topic tells, in a thread of its own.
  void lookAtRig();
  void trigger(const std::string& what, const std::string& service);
  void file(const std::string& service, const std::string& path);
  /// Calls in a thread of its own: a service that does not answer must not stop the window.
  void call(const std::string& what, Call work);
  void say(const QString& words, bool good);
  void look();

  ros::NodeHandle nh_;
  ros::Publisher stop_;
  ros::Subscriber state_, values_;  // their callbacks run in the thread that draws
  ArrayState::ConstPtr array_;
  ros::SteadyTime array_came_, looked_at_rig_;
  std::shared_ptr<Answers> answers_;
  std::string newest_;  // file that was saved last
  QProcess* recorder_;
  QString recorder_says_, quality_held_;
  QString bag_;  // that is or was recorded, or why it failed
  bool stopping_ = false, recorded_ = false;
  QLabel *array_line_, *answer_line_, *scene_line_, *record_line_;
  QComboBox* quality_;
  QPushButton *undo_, *record_;
  QLineEdit *folder_, *clay_;
};

}  // namespace tactile_clay::rviz_plugins
