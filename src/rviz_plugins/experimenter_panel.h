#pragma once

#include <ros/ros.h>
#include <rviz/panel.h>
#include <std_msgs/Empty.h>
#include <tactile_clay/ArrayState.h>

#include <functional>
#include <memory>
#include <string>

class QLabel;
class QLineEdit;
class QPushButton;

namespace tactile_clay::rviz_plugins {

/// What an experimenter needs at hand: a big stop of the array and its reset, and the clay's reset, save and
/// load, with keys that work wherever the focus is. What services answer is told in its last line.
class ExperimenterPanel : public rviz::Panel {
  Q_OBJECT
 public:
  explicit ExperimenterPanel(QWidget* parent = nullptr);
  ~ExperimenterPanel() override;

  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 private:
  /// What a call of a service found, for the thread that draws.
  struct Answers;
  using Call = std::function<bool(std::string& answer)>;  // returns whether it succeeded

  QPushButton* button(const QString& text, const QString& key, const QString& help,
                      const std::function<void()>& action);
  void stop();
  void resetArray();
  void resetClay();
  void saveClay();
  void loadClay();
  void trigger(const std::string& what, const std::string& service);
  void file(const std::string& service, const std::string& path);
  /// Calls in a thread of its own: a service that does not answer must not stop the window.
  void call(const std::string& what, Call work);
  void say(const QString& words, bool good);
  void look();

  ros::NodeHandle nh_;
  ros::Publisher stop_;
  ros::Subscriber state_;  // its callback runs in the thread that draws
  ArrayState::ConstPtr array_;
  ros::SteadyTime array_came_;
  std::shared_ptr<Answers> answers_;
  std::string newest_;  // file that was saved last
  QLabel *array_line_, *answer_line_;
  QLineEdit *folder_, *clay_;
};

}  // namespace tactile_clay::rviz_plugins
