#pragma once

#include <QProcess>
#include <QString>
#include <functional>

namespace tactile_clay::rviz_plugins {

/// A recording of all that the rig does, as `roslaunch tactile_clay record.launch` makes it. It ends when its
/// owner is killed, too. Belongs to the thread that draws.
class Recording {
 public:
  /// @param changed called when one has begun or ended
  explicit Recording(std::function<void()> changed);

  bool runs() const { return process_.state() != QProcess::NotRunning; }
  /// @param bag path of a file that does not exist yet
  void start(const QString& bag);
  /// Asks it to close its bag.
  void stop();
  /// The same, and waits for it.
  void close();

  /// For people, in one line; empty where there was none.
  QString words() const;
  /// Whether the words are good news.
  bool isWell() const { return runs() || recorded_; }

 private:
  void ended(int code);

  std::function<void()> changed_;
  QString says_;
  QString bag_;  // that is or was recorded, or why it failed
  bool stopping_ = false, recorded_ = false;
  QProcess process_;  // last, for it ends first
};

}  // namespace tactile_clay::rviz_plugins
