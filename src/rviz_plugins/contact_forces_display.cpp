#include "rviz_plugins/contact_forces_display.h"

#include <OgreCamera.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>

#include <algorithm>
#include <pluginlib/class_list_macros.hpp>

#include "nodes/cloud.h"
#include "nodes/surface_markers.h"

namespace tactile_clay::rviz_plugins {
namespace {

enum On { clay, skin };

constexpr float length_per_newton = 0.01f;  // m: gathered contacts of a hand that kneads have up to 10 N
constexpr float shaft_diameter = 0.003f;    // m
constexpr float cell_edge = 0.01f;          // m, two samples of the skin: arrows can be told apart

}  // namespace

ContactForcesDisplay::ContactForcesDisplay() {
  on_ = new rviz::EnumProperty("Force on", "clay",
                               "Forces of the hands on the clay, or of the clay on the skin.", this,
                               SLOT(redraw()));
  on_->addOption("clay", clay);
  on_->addOption("skin", skin);
  length_ = new rviz::FloatProperty("Length", length_per_newton, "Length of the arrow of 1 N, m.", this,
                                    SLOT(redraw()));
  length_->setMin(0.0001f);
  thickness_ = new rviz::FloatProperty("Thickness", shaft_diameter, "Diameter of the shafts, m.", this,
                                       SLOT(redraw()));
  thickness_->setMin(0.0001f);
  cell_ =
      new rviz::FloatProperty("Cell", cell_edge,
                              "Forces in a cube of this edge are added up to one arrow, m. 0: an arrow for "
                              "each sample of the skin.",
                              this, SLOT(redraw()));
  cell_->setMin(0.0f);
  color_ =
      new rviz::ColorProperty("Color", QColor(35, 45, 60), "Colour of the arrows.", this, SLOT(redraw()));
  through_ = new rviz::BoolProperty(
      "Show through", true, "If true, arrows are visible through hands and clay.", this, SLOT(redraw()));
}

ContactForcesDisplay::~ContactForcesDisplay() = default;

void ContactForcesDisplay::onInitialize() {
  ArrayDisplay::onInitialize();
  arrows_ = std::make_unique<DrawnObject>(*scene_manager_, *scene_node_, "contact forces");
}

void ContactForcesDisplay::reset() {
  ArrayDisplay::reset();
  message_.reset();
  if (arrows_) (*arrows_)->clear();
}

void ContactForcesDisplay::processMessage(const sensor_msgs::PointCloud2::ConstPtr& message) {
  message_ = message;
  redraw();
}

std::vector<PlacedForce> ContactForcesDisplay::forces() const {
  std::vector<PlacedForce> forces(nodes::pointCount(*message_));
  const auto field = [this](const char* name) { return nodes::column<float>(*message_, name); };
  const auto x = field("x"), y = field("y"), z = field("z"), fx = field("fx"), fy = field("fy"),
             fz = field("fz");
  const float sign = on_->getOptionInt() == clay ? -1.0f : 1.0f;  // clay/contacts has the force on the skin
  for (std::size_t i = 0; i < forces.size(); ++i)
    forces[i] = {{x[i], y[i], z[i]}, sign * Eigen::Vector3f(fx[i], fy[i], fz[i])};
  return forces;
}

void ContactForcesDisplay::redraw() {
  if (!arrows_) return;
  (*arrows_)->clear();
  context_->queueRender();
  if (!message_ || !place(message_->header)) return;
  try {
    const std::vector<PlacedForce> all = gathered(forces(), 0.0f);
    float sum = 0.0f;
    for (const PlacedForce& one : all) sum += one.force.norm();
    const std::vector<PlacedForce> arrows = gathered(all, cell_->getFloat());
    draw(arrows);
    setStatus(rviz::StatusProperty::Ok, "Forces",
              QString("%1 contacts with %2 N in all, %3 arrows")
                  .arg(all.size())
                  .arg(static_cast<double>(sum), 0, 'f', 1)
                  .arg(arrows.size()));
  } catch (const std::exception& error) {
    setStatusStd(rviz::StatusProperty::Error, "Forces", error.what());
  }
}

void ContactForcesDisplay::draw(std::vector<PlacedForce> arrows) {
  const bool through = through_->getBool();
  DrawnObject& object = *arrows_;
  object.pass().setDepthCheckEnabled(!through);
  object->setRenderQueueGroup(through ? Ogre::RENDER_QUEUE_9 : Ogre::RENDER_QUEUE_MAIN);
  // Without depths the last one lies on top: from the farthest to the nearest.
  if (const rviz::ViewController* view = context_->getViewManager()->getCurrent();
      through && view != nullptr) {
    const Ogre::Vector3 toward =
        scene_node_->convertWorldToLocalDirection(-view->getCamera()->getDerivedDirection(), false);
    const Eigen::Vector3f near(toward.x, toward.y, toward.z);
    std::stable_sort(arrows.begin(), arrows.end(), [&](const PlacedForce& a, const PlacedForce& b) {
      return a.at.dot(near) < b.at.dot(near);
    });
  }
  surface::TriangleMesh mesh;
  for (const PlacedForce& arrow : arrows)
    addArrow(mesh, arrow, {length_->getFloat(), thickness_->getFloat()});
  if (mesh.triangles.empty()) return;
  const Ogre::ColourValue chosen = color_->getOgreColor();
  const Eigen::Vector3f color(chosen.r, chosen.g, chosen.b);
  object.begin();
  for (std::size_t k = 0; k < mesh.position.size(); ++k) {
    const Eigen::Vector3f& at = mesh.position[k];
    const Eigen::Vector3f shade = nodes::lit(color, mesh.normal[k]);
    object->position(at.x(), at.y(), at.z());
    object->colour(shade.x(), shade.y(), shade.z());
  }
  for (const auto& [a, b, c] : mesh.triangles) object->triangle(a, b, c);
  object->end();
}

}  // namespace tactile_clay::rviz_plugins

PLUGINLIB_EXPORT_CLASS(tactile_clay::rviz_plugins::ContactForcesDisplay, rviz::Display)
