#include "rviz_plugins/experimenter_panel.h"

#include <QDateTime>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QGridLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QShortcut>
#include <QTimer>
#include <pluginlib/class_list_macros.hpp>
#include <utility>

#include "nodes/topics.h"
#include "rviz_plugins/rig_services.h"

namespace tactile_clay::rviz_plugins {
namespace {

constexpr int look_every = 100;    // ms
constexpr double patience = 2.0;   // s, without array/state
constexpr double rig_every = 3.0;  // s, between questions to the master

QString newFile(const QString& what, const QString& end) {
  return what + "_" + QDateTime::currentDateTime().toString("yyyy-MM-dd_hh-mm-ss-zzz") + end;
}

}  // namespace

ExperimenterPanel::ExperimenterPanel(QWidget* parent)
    : rviz::Panel(parent),
      stop_(nh_.advertise<std_msgs::Empty>(nodes::topic::array_stop, 4)),
      recording_([this] { lookAtRecording(); }),
      parameters_(new ParameterWindow(
          this, nh_.getNamespace(),
          [this](const std::string& node, const LiveValue& value) { change(node, value); })) {
  auto* grid = new QGridLayout;
  setLayout(grid);
  for (QLabel** line : {&array_line_, &record_line_, &answer_line_}) {
    *line = new QLabel;
    (*line)->setWordWrap(true);
    (*line)->setMinimumHeight(2 * fontMetrics().lineSpacing());
  }
  addArray(*grid);
  addClay(*grid);
  addRecording(*grid);
  addForm(*grid);
  grid->addWidget(answer_line_, 9, 0, 1, 3);
  grid->setRowStretch(10, 1);

  state_ = nh_.subscribe<ArrayState>(nodes::topic::array_state, 4, [this](const ArrayState::ConstPtr& state) {
    array_ = state;
    array_came_ = ros::SteadyTime::now();
  });
  log_ = nh_.subscribe<rosgraph_msgs::Log>("/rosout", 100, [this](const rosgraph_msgs::Log::ConstPtr& line) {
    const std::string reason = refusalIn(line->msg, asked_);
    if (!reason.empty()) say(QString::fromStdString(refusal_ = reason), false);
  });
  auto* timer = new QTimer(this);
  connect(timer, &QTimer::timeout, this, [this] { look(); });
  timer->start(look_every);
  subscribeClay();
}

ExperimenterPanel::~ExperimenterPanel() {
  recording_.close();
}

void ExperimenterPanel::addArray(QGridLayout& grid) {
  auto* stop_button = button(grid, {0, 0, 3}, "STOP", "F12", "Silences the array at once, until it is reset.",
                             [this] { stop(); });
  stop_button->setMinimumHeight(64);
  stop_button->setStyleSheet(
      "QPushButton { background: #d2281e; color: white; font-weight: bold; font-size: 20px; border: none; "
      "border-radius: 4px; }");
  button(grid, {1, 0, 3}, "Reset the array", "Shift+F12", "Lets the array sound again.",
         [this] { call("reset of the array", triggerCall(nh_.resolveName(nodes::topic::array_reset))); });
  grid.addWidget(array_line_, 2, 0, 1, 3);
}

void ExperimenterPanel::addClay(QGridLayout& grid) {
  button(grid, {3, 0, 1}, "Reset the clay", "F8", "Puts the clay back to the start of the scene.",
         [this] { call("reset of the clay", triggerCall(clay_name_ + "/reset")); });
  button(grid, {3, 1, 1}, "Save", "F5",
         "Saves the clay to a new file in the folder. Its name has the date and time.",
         [this] { saveClay(); });
  button(grid, {3, 2, 1}, "Load", "F9",
         "Loads the file that this panel saved last. If there is none, asks for a file.",
         [this] { loadClay(); });
  undo_ = button(grid, {4, 2, 1}, "Undo", "Ctrl+Z",
                 "Takes the clay back by two simulated seconds, each time you press it.", [this] { undo(); });
  const QString help = "Writes the surface of the clay as a closed mesh to a new file in the folder: ";
  stl_ = button(grid, {6, 0, 2}, "Export STL", "F7", help + "in millimetres, for 3D printers.",
                [this] { exportMesh(".stl"); });
  ply_ = button(grid, {6, 2, 1}, "PLY", "Shift+F7", help + "in metres, with colours.",
                [this] { exportMesh(".ply"); });
  for (QPushButton* served : {undo_, stl_, ply_}) served->hide();
}

void ExperimenterPanel::addRecording(QGridLayout& grid) {
  record_ = button(grid, {4, 0, 2}, "Record", "F6",
                   "Records all that the rig does to a new bag in the folder, on this computer.",
                   [this] { recording_.runs() ? recording_.stop() : record(); });
  record_line_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  record_line_->hide();
  grid.addWidget(record_line_, 5, 0, 1, 3);
}

void ExperimenterPanel::addForm(QGridLayout& grid) {
  auto* form = new QFormLayout;
  scene_line_ = new QLabel("not known");
  form->addRow("Scene", scene_line_);
  quality_ = new QualityBox([this](const std::string& quality) {
    change(clay_name_, {"quality", "str", quality});
  });
  form->addRow("&Quality", quality_);
  folder_ = new QLineEdit(QDir::homePath());
  folder_->setToolTip(
      "Folder for sculptures and meshes on the computer that simulates the clay, and for bags on this one.");
  form->addRow("Folder", folder_);
  clay_ = new QLineEdit("clay_simulator");
  clay_->setToolTip("Name of the node that simulates the clay.");
  form->addRow("Clay", clay_);
  grid.addLayout(form, 7, 0, 1, 3);
  auto* more = new QPushButton("&More parameters");
  more->setToolTip("Opens a table of the live parameters of all nodes: their values, and what may be set.");
  connect(more, &QPushButton::clicked, this, [this] {
    parameters_->show();
    parameters_->raise();
    parameters_->activateWindow();
  });
  grid.addWidget(more, 8, 0, 1, 3);
  for (QLineEdit* line : {folder_, clay_})
    connect(line, &QLineEdit::editingFinished, this, [this] { Q_EMIT configChanged(); });
  connect(clay_, &QLineEdit::editingFinished, this, [this] { subscribeClay(); });
}

/// Follows the clay of this name.
void ExperimenterPanel::subscribeClay() {
  looked_at_rig_ = ros::SteadyTime();
  try {
    const std::string name = clay_->text().toStdString();
    if (name.empty()) throw ros::InvalidNameException("expected the name of the node of the clay");
    clay_name_ = nh_.resolveName(name);
    quality_->follow(clay_name_);
  } catch (const ros::Exception& error) {
    say(error.what(), false);
  }
}

QPushButton* ExperimenterPanel::button(QGridLayout& grid, const Place& place, const QString& text,
                                       const QString& key, const QString& help,
                                       const std::function<void()>& action) {
  auto* made = new QPushButton(text + " (" + key + ")");
  made->setToolTip(help);
  grid.addWidget(made, place.row, place.column, 1, place.width);
  connect(made, &QPushButton::clicked, this, action);
  auto* shortcut = new QShortcut(QKeySequence(key), this);
  shortcut->setContext(Qt::ApplicationShortcut);
  shortcut->setAutoRepeat(false);
  connect(shortcut, &QShortcut::activated, this, [made, action] {
    if (!made->isHidden()) action();
  });
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
    say("stop: no array node received it", false);
  else
    say("stop: sent to " + QString::number(stop_.getNumSubscribers()) + " array nodes", true);
}

void ExperimenterPanel::undo() {
  constexpr double back = 2.0;  // s
  call("undo", undoCall(clay_name_, back));
}

void ExperimenterPanel::saveClay() {
  newest_ = QDir(folder_->text()).filePath(newFile("clay", ".clay")).toStdString();
  call("save", fileCall(clay_name_ + "/save", newest_));
}

void ExperimenterPanel::loadClay() {
  std::string path = newest_;
  if (path.empty())
    path =
        QFileDialog::getOpenFileName(this, "Load clay", folder_->text(), "Sculptures (*.clay);;All files (*)")
            .toStdString();
  if (!path.empty()) call("load", fileCall(clay_name_ + "/load", path));
}

void ExperimenterPanel::exportMesh(const QString& ending) {
  const std::string file = QDir(folder_->text()).filePath(newFile("clay", ending)).toStdString();
  call("export", fileCall(surface() + "/export", file));
}

void ExperimenterPanel::record() {
  recording_.start(QDir(QDir(folder_->text()).absolutePath()).filePath(newFile("run", ".bag")));
}

void ExperimenterPanel::lookAtRecording() {
  record_->setText(recording_.runs() ? "Stop recording (F6)" : "Record (F6)");
  const QString words = recording_.words();
  showLine(*record_line_, words, recording_.isWell() ? News::good : News::bad);
  record_line_->setVisible(!words.isEmpty());
}

void ExperimenterPanel::lookAtRig() {
  const ros::SteadyTime now = ros::SteadyTime::now();
  if ((now - looked_at_rig_).toSec() < rig_every) return;
  looked_at_rig_ = now;
  const ServiceCalls::Rig rig = calls_.rig();
  scene_line_->setText(rig.scene.empty() ? "not known"
                                         : QFileInfo(QString::fromStdString(rig.scene)).completeBaseName());
  scene_line_->setToolTip(QString::fromStdString(rig.scene));
  undo_->setVisible(rig.has_undo);
  for (QPushButton* button : {stl_, ply_}) button->setVisible(rig.has_export);
  calls_.lookAtRig(clay_name_, surface());
}

/// Full name of the node that makes the surface of the clay.
std::string ExperimenterPanel::surface() const {
  return nh_.resolveName("clay_surface");
}

void ExperimenterPanel::call(const std::string& what, ServiceCalls::Call work, const std::string& node) {
  const bool free = calls_.start(what, std::move(work));
  if (free) {
    asked_ = node;
    refusal_.clear();
  }
  say(QString::fromStdString(what) + (free ? " ..." : ": not sent, the call before is not answered yet"),
      free);
}

/// Asks a node for a value of a live parameter.
void ExperimenterPanel::change(const std::string& node, const LiveValue& value) {
  try {
    call(value.name, valueCall(node, value), node);
  } catch (const std::exception& error) {
    say(error.what(), false);
  }
}

void ExperimenterPanel::say(const QString& words, bool good) {
  const News news = good ? News::good : News::bad;
  showLine(*answer_line_, words, news);
  parameters_->say(words, news);
}

void ExperimenterPanel::look() {
  for (const ServiceCalls::Answer& answer : calls_.take()) {
    const bool has_reason = !answer.good && !refusal_.empty();
    say(QString::fromStdString(has_reason ? refusal_ : answer.text), answer.good);
    if (!answer.good) quality_->showHeld();  // the box may show a refused one
  }
  lookAtRig();
  lookAtRecording();
  parameters_->look();
  const bool fresh = array_ && (ros::SteadyTime::now() - array_came_).toSec() < patience;
  const QString words = !fresh ? "array: no news"
                        : array_->emitting
                            ? "array: sounds"
                            : "array: silent, " + QString::fromStdString(array_->silent_reason);
  showLine(*array_line_, words, !fresh ? News::none : array_->emitting ? News::good : News::bad);
}

}  // namespace tactile_clay::rviz_plugins

PLUGINLIB_EXPORT_CLASS(tactile_clay::rviz_plugins::ExperimenterPanel, rviz::Panel)
