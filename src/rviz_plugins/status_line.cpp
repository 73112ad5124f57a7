#include "rviz_plugins/status_line.h"

#include <QLabel>

namespace tactile_clay::rviz_plugins {

void showLine(QLabel& line, const QString& words, News news, int longest) {
  const char* color = news == News::good ? "#287846" : news == News::bad ? "#b4281e" : "#808080";
  const QString style = QString("color: ") + color;
  if (line.toolTip() == words && line.styleSheet() == style) return;
  line.setText(words.size() > longest ? words.left(longest) + "…" : words);
  line.setToolTip(words);
  line.setStyleSheet(style);
}

}  // namespace tactile_clay::rviz_plugins
