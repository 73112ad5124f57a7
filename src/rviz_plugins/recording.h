#pragma once

#include <QProcess>
#include <QString>
#include <functional>

namespace tactile_clay::rviz_plugins {

/// A recording of all that the rig does, made by `roslaunch tactile_clay record.launch`. It ends when its
/// owner is killed, too. For use in the thread that draws.
class Recording {
 public:
  /// @param changed called when a recording has begun or ended
  explicit Recording(std::function<void()> changed);

  bool runs() const { return process_.state() != QProcess::NotRunning; }
  /// @param bag path of a file that does not exist yet
  void start(const QString& bag);
  /// Asks it to close its bag.
  void stop();
  /// Asks it to close its bag, and waits for it.
  void close();

  /// The state in one line; empty if there was no recording.
  QString words() const;
  /// Whether `words` reports no failure.
  bool isWell() const { return runs() || recorded_; }

 private:
  void ended(int code);

  std::function<void()> changed_;
  QString says_;
  QString bag_;  // bag that is or was recorded, or why it failed
  bool stopping_ = false, recorded_ = false;
  QProcess process_;  // last, so that it is destroyed first
};

}  // namespace tactile_clay::rviz_plugins
