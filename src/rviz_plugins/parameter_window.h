#pragma once

#include <QDialog>
#include <functional>
#include <string>
#include <vector>

#include "rviz_plugins/live_nodes.h"
#include "rviz_plugins/status_line.h"

class QLabel;

namespace tactile_clay::rviz_plugins {

class ParameterTable;

/// A table of the live parameters of all nodes, with their values and ranges. A value that is typed is asked
/// for; the table shows the value that the node holds.
class ParameterWindow : public QDialog {
 public:
  /// Asks a node for a value.
  using Ask = std::function<void(const std::string& node, const LiveValue& value)>;

  /// @param space namespace of the nodes, such as `/`
  ParameterWindow(QWidget* parent, const std::string& space, Ask ask);

  /// To be called several times a second: shows new values, and now and then looks for nodes.
  void look();
  /// Shows the answer of a node in the last line.
  void say(const QString& words, News news) { showLine(*line_, words, news, 1000); }

 private:
  struct Row {
    std::string node;
    LiveParameter parameter;
  };
  void showRow(int at, const Row& row);
  void edited(int at);

  std::string space_;
  Ask ask_;
  LiveNodes nodes_;
  std::vector<Row> rows_;  // as the table shows them
  int looks_ = 0;
  ParameterTable* table_;
  QLabel* line_;
};

}  // namespace tactile_clay::rviz_plugins
