#include "rviz_plugins/recording.h"

#include <signal.h>

#include <QFileInfo>
#include <QStringList>
#include <utility>

namespace tactile_clay::rviz_plugins {
namespace {

constexpr int max_output = 20000;    // characters of a recording's output that are kept
constexpr int closing_time = 15000;  // ms, maximum wait until a recording has closed its bag

}  // namespace

Recording::Recording(std::function<void()> changed) : changed_(std::move(changed)) {
  process_.setProcessChannelMode(QProcess::MergedChannels);
  QObject::connect(&process_, &QProcess::readyRead, &process_, [this] {
    says_ = (says_ + QString::fromLocal8Bit(process_.readAll())).right(max_output);
  });
  QObject::connect(&process_, QOverload<int, QProcess::ExitStatus>::of(&QProcess::finished), &process_,
                   [this](int code, QProcess::ExitStatus) { ended(code); });
  QObject::connect(&process_, &QProcess::errorOccurred, &process_, [this](QProcess::ProcessError error) {
    if (error == QProcess::FailedToStart) bag_ = "recording failed: the program setpriv is not installed";
  });
}

void Recording::start(const QString& bag) {
  bag_ = bag;
  stopping_ = recorded_ = false;
  says_.clear();
  process_.start("setpriv",
                 {"--pdeathsig", "INT", "roslaunch", "tactile_clay", "record.launch", "record:=" + bag_});
  changed_();
}

void Recording::stop() {
  stopping_ = true;
  if (process_.processId() > 0) kill(static_cast<pid_t>(process_.processId()), SIGINT);
  changed_();
}

void Recording::close() {
  if (!runs()) return;
  stop();
  process_.waitForFinished(closing_time);
}

void Recording::ended(int code) {
  recorded_ = QFileInfo::exists(bag_);
  if (!recorded_) {
    // A line of the program itself has the reason; lines of roslaunch begin otherwise.
    const QStringList all = says_.split('\n');
    const QStringList lines = all.filter("tactile_clay:") + all.filter("record: ");
    bag_ = "recording failed: " +
           (lines.isEmpty() ? QString("roslaunch ended with %1").arg(code) : lines.front());
  }
  changed_();
}

QString Recording::words() const {
  if (!runs()) return recorded_ ? "recorded " + QFileInfo(bag_).fileName() : bag_;
  if (stopping_) return "closing the bag";
  const double megabytes = 1e-6 * static_cast<double>(QFileInfo(bag_ + ".active").size());
  return QString("recording, %1 MB").arg(megabytes, 0, 'f', 1);
}

}  // namespace tactile_clay::rviz_plugins
