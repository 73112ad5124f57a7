#include "rviz_plugins/parameter_window.h"

#include <QComboBox>
#include <QHeaderView>
#include <QLabel>
#include <QSignalBlocker>
#include <QStyledItemDelegate>
#include <QTableWidget>
#include <QVBoxLayout>
#include <utility>

namespace tactile_clay::rviz_plugins {
namespace {

enum Column { name_column, value_column, low_column, high_column, columns };

constexpr int choices_role = Qt::UserRole;  // of a value: its allowed values
constexpr int search_every = 20;            // looks between questions to the master

/// A value that has choices is edited with a list of them.
class ValueDelegate : public QStyledItemDelegate {
 public:
  using QStyledItemDelegate::QStyledItemDelegate;

  QWidget* createEditor(QWidget* parent, const QStyleOptionViewItem& option,
                        const QModelIndex& index) const override {
    const QStringList choices = index.data(choices_role).toStringList();
    if (choices.isEmpty()) return QStyledItemDelegate::createEditor(parent, option, index);
    auto* list = new QComboBox(parent);
    list->addItems(choices);
    return list;
  }
};

QStringList choicesOf(const LiveParameter& parameter) {
  QStringList choices;
  for (const std::string& choice : parameter.choices) choices << QString::fromStdString(choice);
  return choices;
}

QString helpOf(const LiveParameter& parameter) {
  QString help = QString::fromStdString(parameter.meaning);
  if (!parameter.choices.empty()) help += "; one of " + choicesOf(parameter).join(", ");
  if (!parameter.fallback.empty()) help += "; default " + QString::fromStdString(parameter.fallback);
  return "<p>" + help.toHtmlEscaped() + "</p>";  // wrapped at the end of a line
}

}  // namespace

class ParameterTable : public QTableWidget {
 public:
  explicit ParameterTable(QWidget* parent) : QTableWidget(0, columns, parent) {
    setHorizontalHeaderLabels({"Parameter", "Value", "Minimum", "Maximum"});
    setItemDelegateForColumn(value_column, new ValueDelegate(this));
    setEditTriggers(AnyKeyPressed | EditKeyPressed | DoubleClicked);
    verticalHeader()->hide();
    horizontalHeader()->setSectionResizeMode(name_column, QHeaderView::Stretch);
    setTabKeyNavigation(false);  // so that Tab leaves the table
  }

  bool isEdited() const { return state() == EditingState; }

  void write(int row, Column column, const QString& text, const QString& help) {
    if (item(row, column) == nullptr) {
      auto* made = new QTableWidgetItem;
      if (column != value_column) made->setFlags(Qt::ItemIsEnabled | Qt::ItemIsSelectable);
      setItem(row, column, made);
    }
    QTableWidgetItem& cell = *item(row, column);
    if (cell.text() != text) cell.setText(text);
    if (cell.toolTip() != help) cell.setToolTip(help);
  }
};

ParameterWindow::ParameterWindow(QWidget* parent, const std::string& space, Ask ask)
    : QDialog(parent),
      space_(space),
      ask_(std::move(ask)),
      table_(new ParameterTable(this)),
      line_(new QLabel) {
  constexpr int width = 620, height = 560;  // pixels
  setWindowTitle("Live parameters");
  resize(width, height);
  line_->setWordWrap(true);
  line_->setMinimumHeight(2 * fontMetrics().lineSpacing());
  auto* column = new QVBoxLayout(this);
  column->addWidget(table_);
  column->addWidget(line_);
  table_->setFocus();
  connect(table_, &QTableWidget::cellChanged, this, [this](int row, int) { edited(row); });
}

void ParameterWindow::look() {
  if (!isVisible() || table_->isEdited()) return;  // a row that is edited stays where it is
  if (looks_++ % search_every == 0) nodes_.look(space_);
  rows_.clear();
  for (const auto& [node, parameters] : nodes_.parameters())
    for (const LiveParameter& parameter : parameters) rows_.push_back({node, parameter});
  const QSignalBlocker quiet(table_);
  table_->setRowCount(static_cast<int>(rows_.size()));
  for (std::size_t k = 0; k < rows_.size(); ++k) showRow(static_cast<int>(k), rows_[k]);
  if (table_->currentRow() < 0 && !rows_.empty()) table_->setCurrentCell(0, value_column);
}

void ParameterWindow::showRow(int at, const Row& row) {
  const LiveParameter& parameter = row.parameter;
  const std::string name = row.node.substr(space_ == "/" ? 1 : space_.size() + 1) + "/" + parameter.now.name;
  const QString help = helpOf(parameter);
  table_->write(at, name_column, QString::fromStdString(name), help);
  table_->write(at, value_column, QString::fromStdString(parameter.now.text), help);
  table_->write(at, low_column, QString::fromStdString(parameter.low), help);
  table_->write(at, high_column, QString::fromStdString(parameter.high), help);
  table_->item(at, value_column)->setData(choices_role, choicesOf(parameter));
}

/// The cell shows the present value again until the node holds the new one.
void ParameterWindow::edited(int at) {
  const Row& row = rows_.at(static_cast<std::size_t>(at));
  QTableWidgetItem& cell = *table_->item(at, value_column);
  LiveValue wanted = row.parameter.now;
  wanted.text = cell.text().toStdString();
  {
    const QSignalBlocker quiet(table_);
    cell.setText(QString::fromStdString(row.parameter.now.text));
  }
  ask_(row.node, wanted);
}

}  // namespace tactile_clay::rviz_plugins
