#include "rviz_plugins/experimenter_panel.h"

#include <std_srvs/Trigger.h>
#include <tactile_clay/SculptureFile.h>

#include <QDateTime>
#include <QDir>
#include <QFileDialog>
#include <QFormLayout>
#include <QGridLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QShortcut>
#include <QTimer>
#include <deque>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>
#include <thread>
#include <utility>

#include "nodes/topics.h"

namespace tactile_clay::rviz_plugins {
namespace {

constexpr int look_every = 100;   // ms
constexpr double patience = 2.0;  // s, without array/state
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

}  // namespace

struct ExperimenterPanel::Answers {
  struct Answer {
    std::string text;
    bool good;
  };
  std::mutex mutex;
  std::deque<Answer> answers;
  bool busy = false;
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
  array_line_ = new QLabel;
  array_line_->setWordWrap(true);
  grid->addWidget(array_line_, 2, 0, 1, 3);
  grid->addWidget(button("Reset the clay", "F8", "The scene as it began.", [this] { resetClay(); }), 3, 0);
  grid->addWidget(button("Save", "F5", "Saves the clay to a new file of the folder, named by the time.",
                         [this] { saveClay(); }),
                  3, 1);
  grid->addWidget(button("Load", "F9",
                         "Goes on from the file that was saved last here; asks for one where there is none.",
                         [this] { loadClay(); }),
                  3, 2);
  auto* form = new QFormLayout;
  folder_ = new QLineEdit(QDir::homePath());
  folder_->setToolTip("Where sculptures are saved, as the computer of the clay names it.");
  form->addRow("Folder", folder_);
  clay_ = new QLineEdit("clay_simulator");
  clay_->setToolTip("Name of the node that simulates the clay.");
  form->addRow("Clay", clay_);
  grid->addLayout(form, 4, 0, 1, 3);
  answer_line_ = new QLabel;
  answer_line_->setWordWrap(true);
  grid->addWidget(answer_line_, 5, 0, 1, 3);
  grid->setRowStretch(6, 1);
  for (QLineEdit* line : {folder_, clay_})
    connect(line, &QLineEdit::editingFinished, this, [this] { Q_EMIT configChanged(); });

  state_ = nh_.subscribe<ArrayState>(nodes::topic::array_state, 4, [this](const ArrayState::ConstPtr& state) {
    array_ = state;
    array_came_ = ros::SteadyTime::now();
  });
  auto* timer = new QTimer(this);
  connect(timer, &QTimer::timeout, this, [this] { look(); });
  timer->start(look_every);
}

ExperimenterPanel::~ExperimenterPanel() = default;

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

void ExperimenterPanel::trigger(const std::string& what, const std::string& service) {
  call(what, [name = nh_.resolveName(service)](std::string& answer) {
    std_srvs::Trigger request;
    if (!callService(name, request, answer)) return false;
    answer = request.response.message.empty() ? "done" : request.response.message;
    return static_cast<bool>(request.response.success);
  });
}

void ExperimenterPanel::saveClay() {
  const QString name = "clay_" + QDateTime::currentDateTime().toString("yyyy-MM-dd_hh-mm-ss-zzz") + ".clay";
  newest_ = QDir(folder_->text()).filePath(name).toStdString();
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
  answer_line_->setText(words);
  answer_line_->setStyleSheet(QString("color: ") + (good ? good_color : bad_color));
}

void ExperimenterPanel::look() {
  {
    const std::lock_guard<std::mutex> lock(answers_->mutex);
    for (const Answers::Answer& answer : answers_->answers)
      say(QString::fromStdString(answer.text), answer.good);
    answers_->answers.clear();
  }
  const bool fresh = array_ && (ros::SteadyTime::now() - array_came_).toSec() < patience;
  const QString words = !fresh ? "array: no news"
                        : array_->emitting
                            ? "array: sounds"
                            : "array: silent, " + QString::fromStdString(array_->silent_reason);
  if (words == array_line_->text()) return;
  array_line_->setText(words);
  array_line_->setStyleSheet(QString("color: ") + (!fresh             ? no_color
                                                   : array_->emitting ? good_color
                                                                      : bad_color));
}

}  // namespace tactile_clay::rviz_plugins

PLUGINLIB_EXPORT_CLASS(tactile_clay::rviz_plugins::ExperimenterPanel, rviz::Panel)
