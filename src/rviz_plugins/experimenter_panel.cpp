#include "rviz_plugins/experimenter_panel.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <signal.h>
#include <std_srvs/Trigger.h>
#include <tactile_clay/SculptureFile.h>
#include <tactile_clay/Undo.h>
#include <yaml-cpp/yaml.h>

#include <QComboBox>
#include <QDateTime>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QGridLayout>
#include <QLabel>
#include <QLineEdit>
#include <QProcess>
#include <QPushButton>
#include <QShortcut>
#include <QTimer>
#include <deque>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>
#include <thread>
#include <utility>

#include "nodes/share.h"
#include "nodes/topics.h"

namespace tactile_clay::rviz_plugins {
namespace {

constexpr int look_every = 100;      // ms
constexpr double patience = 2.0;     // s, without array/state
constexpr double rig_every = 3.0;    // s, between questions to the master
constexpr int most_output = 20000;   // characters of what a recording says
constexpr int closing_time = 15000;  // ms, in which a recording has closed its bag
constexpr char good_color[] = "#287846", bad_color[] = "#b4281e", no_color[] = "#808080";

template <typename Service>
bool callService(const std::string& name, Service& service, std::string& answer) {
  if (!ros::service::exists(name, false)) {
    answer = "nobody serves " + name;
    return false;
  }
  if (ros::service::call(name, service)) return true;
  answer = name + " failed";
  return false;
}

/// Presets of the quality of a step.
QStringList qualities() {
  QStringList names;
  try {
    for (const auto& preset : YAML::LoadFile(nodes::packageFolder() + "/config/quality.yaml"))
      names.append(QString::fromStdString(preset.first.as<std::string>()));
  } catch (const std::exception&) {
    // Then the clay itself tells of one.
  }
  return names;
}

/// Long words are cut, for lines must not press others out of the panel; the tool tip has all of them.
void showLine(QLabel& line, const QString& words, const char* color) {
  constexpr int most = 80;  // letters, two lines
  const QString style = QString("color: ") + color;
  if (line.toolTip() == words && line.styleSheet() == style) return;
  line.setText(words.size() > most ? words.left(most) + "…" : words);
  line.setToolTip(words);
  line.setStyleSheet(style);
}

QString newName(const QString& what, const QString& end) {
  return what + "_" + QDateTime::currentDateTime().toString("yyyy-MM-dd_hh-mm-ss-zzz") + end;
}

}  // namespace

struct ExperimenterPanel::Answers {
  struct Answer {
    std::string text;
    bool good;
  };
  std::mutex mutex;
  std::deque<Answer> answers;
  bool busy = false;
  bool looking = false;   // at the rig
  std::string scene;      // as the clay was started with it
  bool has_undo = false;  // whether the clay serves it
};

ExperimenterPanel::ExperimenterPanel(QWidget* parent)
    : rviz::Panel(parent),
      stop_(nh_.advertise<std_msgs::Empty>(nodes::topic::array_stop, 4)),
      answers_(std::make_shared<Answers>()) {
  auto* grid = new QGridLayout;
  setLayout(grid);
  auto* stop_button =
      button("STOP", "F12", "The array is silent at once, until it is reset.", [this] { stop(); });
  stop_button->setMinimumHeight(64);
  stop_button->setStyleSheet(
      "QPushButton { background: #d2281e; color: white; font-weight: bold; font-size: 20px; border: none; "
      "border-radius: 4px; }");
  grid->addWidget(stop_button, 0, 0, 1, 3);
  grid->addWidget(button("Reset the array", "Shift+F12", "Sounds again with the next focal points.",
                         [this] { resetArray(); }),
                  1, 0, 1, 3);
  for (QLabel** line : {&array_line_, &record_line_, &answer_line_}) {
    *line = new QLabel;
    (*line)->setWordWrap(true);
    (*line)->setMinimumHeight(2 * fontMetrics().lineSpacing());
  }
  grid->addWidget(array_line_, 2, 0, 1, 3);
  grid->addWidget(button("Reset the clay", "F8", "The scene as it began.", [this] { resetClay(); }), 3, 0);
  grid->addWidget(button("Save", "F5", "Saves the clay to a new file of the folder, named by the time.",
                         [this] { saveClay(); }),
                  3, 1);
  grid->addWidget(button("Load", "F9",
                         "Goes on from the file that was saved last here; asks for one where there is none.",
                         [this] { loadClay(); }),
                  3, 2);
  undo_ = button("Undo", "Ctrl+Z", "The clay as it was two simulated seconds before; again: four.", [this] {
    if (!undo_->isHidden()) undo();
  });
  undo_->hide();
  grid->addWidget(undo_, 4, 2);
  record_ = button("Record", "F6", "All that the rig does, to a new bag of the folder on this computer.",
                   [this] { recorder_->state() == QProcess::NotRunning ? record() : stopRecording(); });
  grid->addWidget(record_, 4, 0, 1, 2);
  record_line_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  record_line_->hide();
  grid->addWidget(record_line_, 5, 0, 1, 3);
  auto* form = new QFormLayout;
  scene_line_ = new QLabel("not known");
  form->addRow("Scene", scene_line_);
  quality_ = new QComboBox;
  quality_->setToolTip(
      "How well a step of the clay is solved, from the next frame on (Alt+Q, then up and down).");
  quality_->setEnabled(false);
  form->addRow("&Quality", quality_);
  folder_ = new QLineEdit(QDir::homePath());
  folder_->setToolTip(
      "Where sculptures are saved, as the computer of the clay names it, and bags, on this one.");
  form->addRow("Folder", folder_);
  clay_ = new QLineEdit("clay_simulator");
  clay_->setToolTip("Name of the node that simulates the clay.");
  form->addRow("Clay", clay_);
  grid->addLayout(form, 6, 0, 1, 3);
  if (nodes::hasPackage("rqt_reconfigure")) {
    auto* more = new QPushButton("&More parameters");
    more->setToolTip("Opens rqt_reconfigure, with a slider for each parameter that may change.");
    connect(more, &QPushButton::clicked, this, [] {
      QProcess::startDetached("rosrun", {"rqt_reconfigure", "rqt_reconfigure"});
    });
    grid->addWidget(more, 7, 0, 1, 3);
  }
  grid->addWidget(answer_line_, 8, 0, 1, 3);
  grid->setRowStretch(9, 1);
  for (QLineEdit* line : {folder_, clay_})
    connect(line, &QLineEdit::editingFinished, this, [this] { Q_EMIT configChanged(); });
  connect(clay_, &QLineEdit::editingFinished, this, [this] { subscribeClay(); });
  connect(quality_, QOverload<int>::of(&QComboBox::activated), this,
          [this](int) { setQuality(quality_->currentText()); });
  recorder_ = new QProcess(this);
  recorder_->setProcessChannelMode(QProcess::MergedChannels);
  connect(recorder_, &QProcess::readyRead, this, [this] {
    recorder_says_ = (recorder_says_ + QString::fromLocal8Bit(recorder_->readAll())).right(most_output);
  });
  connect(recorder_, QOverload<int, QProcess::ExitStatus>::of(&QProcess::finished), this,
          [this](int code, QProcess::ExitStatus) { recordingEnded(code); });
  connect(recorder_, &QProcess::errorOccurred, this, [this](QProcess::ProcessError error) {
    if (error == QProcess::FailedToStart) bag_ = "recording failed: there is no program setpriv";
  });

  state_ = nh_.subscribe<ArrayState>(nodes::topic::array_state, 4, [this](const ArrayState::ConstPtr& state) {
    array_ = state;
    array_came_ = ros::SteadyTime::now();
  });
  auto* timer = new QTimer(this);
  connect(timer, &QTimer::timeout, this, [this] { look(); });
  timer->start(look_every);
  subscribeClay();
}

ExperimenterPanel::~ExperimenterPanel() {
  if (recorder_->state() == QProcess::NotRunning) return;
  stopRecording();
  recorder_->waitForFinished(closing_time);
}

/// The quality that holds, from the clay.
void ExperimenterPanel::subscribeClay() {
  quality_->clear();
  quality_->addItems(qualities());
  quality_->setCurrentIndex(-1);
  quality_held_.clear();
  quality_->setEnabled(false);
  looked_at_rig_ = ros::SteadyTime();
  const std::string clay = clay_->text().toStdString();
  try {
    values_ = nh_.subscribe<dynamic_reconfigure::Config>(
        clay + "/parameter_updates", 4, [this](const dynamic_reconfigure::Config::ConstPtr& all) {
          for (const auto& value : all->strs) {
            if (value.name != "quality") continue;
            quality_held_ = QString::fromStdString(value.value);
            if (quality_->findText(quality_held_) < 0) quality_->addItem(quality_held_);
            quality_->setCurrentText(quality_held_);
            quality_->setEnabled(true);
          }
        });
  } catch (const ros::Exception& error) {
    say(error.what(), false);
  }
}

QPushButton* ExperimenterPanel::button(const QString& text, const QString& key, const QString& help,
                                       const std::function<void()>& action) {
  auto* made = new QPushButton(text + " (" + key + ")");
  made->setToolTip(help);
  connect(made, &QPushButton::clicked, this, action);
  auto* shortcut = new QShortcut(QKeySequence(key), this);
  shortcut->setContext(Qt::ApplicationShortcut);
  shortcut->setAutoRepeat(false);
  connect(shortcut, &QShortcut::activated, this, action);
  return made;
}

void ExperimenterPanel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString text;
  if (config.mapGetString("Folder", &text)) folder_->setText(text);
  if (config.mapGetString("Clay", &text)) clay_->setText(text);
  subscribeClay();
}

void ExperimenterPanel::save(rviz::Config config) const {
  rviz::Panel::save(config);
  config.mapSetValue("Folder", folder_->text());
  config.mapSetValue("Clay", clay_->text());
}

void ExperimenterPanel::stop() {
  stop_.publish(std_msgs::Empty());
  if (stop_.getNumSubscribers() == 0)
    say("stop: no array hears it", false);
  else
    say("stop: sent to " + QString::number(stop_.getNumSubscribers()) + " array nodes", true);
}

void ExperimenterPanel::resetArray() {
  trigger("reset of the array", nodes::topic::array_reset);
}

void ExperimenterPanel::resetClay() {
  trigger("reset of the clay", clay_->text().toStdString() + "/reset");
}

void ExperimenterPanel::undo() {
  constexpr double back = 2.0;  // s
  call("undo", [name = nh_.resolveName(clay_->text().toStdString() + "/undo")](std::string& answer) {
    Undo request;
    request.request.seconds = back;
    if (!callService(name, request, answer)) return false;
    answer = request.response.message;
    return static_cast<bool>(request.response.success);
  });
}

void ExperimenterPanel::trigger(const std::string& what, const std::string& service) {
  call(what, [name = nh_.resolveName(service)](std::string& answer) {
    std_srvs::Trigger request;
    if (!callService(name, request, answer)) return false;
    answer = request.response.message.empty() ? "done" : request.response.message;
    return static_cast<bool>(request.response.success);
  });
}

void ExperimenterPanel::saveClay() {
  newest_ = QDir(folder_->text()).filePath(newName("clay", ".clay")).toStdString();
  file("save", newest_);
}

void ExperimenterPanel::loadClay() {
  std::string path = newest_;
  if (path.empty())
    path =
        QFileDialog::getOpenFileName(this, "Load clay", folder_->text(), "Sculptures (*.clay);;All files (*)")
            .toStdString();
  if (!path.empty()) file("load", path);
}

void ExperimenterPanel::setQuality(const QString& quality) {
  call("quality", [name = nh_.resolveName(clay_->text().toStdString() + "/set_parameters"),
                   quality = quality.toStdString()](std::string& answer) {
    dynamic_reconfigure::Reconfigure request;
    dynamic_reconfigure::StrParameter value;
    value.name = "quality";
    value.value = quality;
    request.request.config.strs.push_back(value);
    if (!callService(name, request, answer)) return false;
    answer = quality;
    return true;
  });
}

/// What `roslaunch tactile_clay record.launch` records. It ends when rviz is killed, too.
void ExperimenterPanel::record() {
  bag_ = QDir(QDir(folder_->text()).absolutePath()).filePath(newName("run", ".bag"));
  stopping_ = recorded_ = false;
  recorder_says_.clear();
  recorder_->start("setpriv",
                   {"--pdeathsig", "INT", "roslaunch", "tactile_clay", "record.launch", "record:=" + bag_});
  lookAtRecording();
}

void ExperimenterPanel::stopRecording() {
  stopping_ = true;
  if (recorder_->processId() > 0) kill(static_cast<pid_t>(recorder_->processId()), SIGINT);
  lookAtRecording();
}

void ExperimenterPanel::recordingEnded(int code) {
  recorded_ = QFileInfo::exists(bag_);
  if (!recorded_) {
    // The line that tells why is the program's own; those of roslaunch begin otherwise.
    const QStringList all = recorder_says_.split('\n');
    const QStringList lines = all.filter("tactile_clay:") + all.filter("record: ");
    bag_ = "recording failed: " +
           (lines.isEmpty() ? QString("roslaunch ended with %1").arg(code) : lines.front());
  }
  lookAtRecording();
}

void ExperimenterPanel::lookAtRecording() {
  const bool runs = recorder_->state() != QProcess::NotRunning;
  const double megabytes = 1e-6 * static_cast<double>(QFileInfo(bag_ + ".active").size());
  record_->setText(runs ? "Stop recording (F6)" : "Record (F6)");
  const QString words = !runs       ? recorded_ ? "recorded " + QFileInfo(bag_).fileName() : bag_
                        : stopping_ ? QString("closing the bag")
                                    : QString("recording, %1 MB").arg(megabytes, 0, 'f', 1);
  showLine(*record_line_, words, runs || recorded_ ? good_color : bad_color);
  record_line_->setVisible(!bag_.isEmpty());
}

void ExperimenterPanel::lookAtRig() {
  const ros::SteadyTime now = ros::SteadyTime::now();
  if ((now - looked_at_rig_).toSec() < rig_every) return;
  looked_at_rig_ = now;
  {
    const std::lock_guard<std::mutex> lock(answers_->mutex);
    scene_line_->setText(answers_->scene.empty()
                             ? "not known"
                             : QFileInfo(QString::fromStdString(answers_->scene)).completeBaseName());
    scene_line_->setToolTip(QString::fromStdString(answers_->scene));
    undo_->setVisible(answers_->has_undo);
    if (answers_->looking) return;
    answers_->looking = true;
  }
  std::thread([answers = answers_, clay = nh_.resolveName(clay_->text().toStdString())] {
    std::string scene;
    ros::param::get(clay + "/scene", scene);
    const bool has_undo = ros::service::exists(clay + "/undo", false);
    const std::lock_guard<std::mutex> lock(answers->mutex);
    answers->scene = scene;
    answers->has_undo = has_undo;
    answers->looking = false;
  }).detach();
}

void ExperimenterPanel::file(const std::string& service, const std::string& path) {
  call(service,
       [name = nh_.resolveName(clay_->text().toStdString() + "/" + service), path](std::string& answer) {
         SculptureFile request;
         request.request.file = path;
         if (!callService(name, request, answer)) return false;
         answer = request.response.message;
         return static_cast<bool>(request.response.success);
       });
}

void ExperimenterPanel::call(const std::string& what, Call work) {
  {
    const std::lock_guard<std::mutex> lock(answers_->mutex);
    if (answers_->busy) {
      say(QString::fromStdString(what) + ": left out, the one before it is not answered yet", false);
      return;
    }
    answers_->busy = true;
  }
  say(QString::fromStdString(what) + " ...", true);
  std::thread([answers = answers_, what, work = std::move(work)] {
    std::string answer;
    bool good = false;
    try {
      good = work(answer);
    } catch (const std::exception& error) {
      answer = error.what();
    }
    const std::lock_guard<std::mutex> lock(answers->mutex);
    answers->answers.push_back({what + ": " + answer, good});
    answers->busy = false;
  }).detach();
}

void ExperimenterPanel::say(const QString& words, bool good) {
  showLine(*answer_line_, words, good ? good_color : bad_color);
}

void ExperimenterPanel::look() {
  {
    const std::lock_guard<std::mutex> lock(answers_->mutex);
    for (const Answers::Answer& answer : answers_->answers) {
      say(QString::fromStdString(answer.text), answer.good);
      if (!answer.good) quality_->setCurrentText(quality_held_);  // which may be what was refused
    }
    answers_->answers.clear();
  }
  lookAtRig();
  lookAtRecording();
  const bool fresh = array_ && (ros::SteadyTime::now() - array_came_).toSec() < patience;
  const QString words = !fresh ? "array: no news"
                        : array_->emitting
                            ? "array: sounds"
                            : "array: silent, " + QString::fromStdString(array_->silent_reason);
  showLine(*array_line_, words, !fresh ? no_color : array_->emitting ? good_color : bad_color);
}

}  // namespace tactile_clay::rviz_plugins

PLUGINLIB_EXPORT_CLASS(tactile_clay::rviz_plugins::ExperimenterPanel, rviz::Panel)
