#include "rviz_plugins/quality_box.h"

#include <dynamic_reconfigure/Config.h>

#include "rviz_plugins/live_values.h"
#include "rviz_plugins/rig_services.h"

namespace tactile_clay::rviz_plugins {

QualityBox::QualityBox(const std::function<void(const std::string& quality)>& ask) {
  setToolTip("How accurately the clay is simulated, from the next frame on (Alt+Q, then up and down).");
  setEnabled(false);
  connect(this, QOverload<int>::of(&QComboBox::activated), this,
          [this, ask](int) { ask(currentText().toStdString()); });
}

void QualityBox::follow(const std::string& clay) {
  clear();
  for (const std::string& name : qualities()) addItem(QString::fromStdString(name));
  setCurrentIndex(-1);
  held_.clear();
  setEnabled(false);
  values_ = nh_.subscribe<dynamic_reconfigure::Config>(
      clay + live_updates, 4, [this](const dynamic_reconfigure::Config::ConstPtr& all) {
        const QString quality = QString::fromStdString(textOf(*all, "quality"));
        if (quality.isEmpty()) return;
        held_ = quality;
        if (findText(held_) < 0) addItem(held_);
        setCurrentText(held_);
        setEnabled(true);
      });
}

}  // namespace tactile_clay::rviz_plugins
