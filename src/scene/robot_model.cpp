#include "scene/robot_model.h"

#include <tinyxml2.h>

#include <Eigen/Geometry>
#include <cctype>
#include <cmath>
#include <locale>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "files/input_file.h"
#include "scene/files.h"
#include "scene/text_file.h"
#include "scene/xacro.h"
#include "scene/xml_encoding.h"
#include "values/pose.h"
#include "values/text.h"

namespace tactile_clay::scene {
namespace {

namespace fs = std::filesystem;
using tinyxml2::XMLElement;

constexpr char world[] = "world";
constexpr std::size_t max_links = 1000;  // readers of a model go down its tree by recursion
const std::set<std::string> frames_of_the_rig = {"tracker", "array", "hand_left", "hand_right"};

[[noreturn]] void fail(const XMLElement& where, const std::string& what) {
  throw std::runtime_error("urdf: line " + std::to_string(where.GetLineNum()) + ": " + what);
}

std::string attribute(const XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value == nullptr ? "" : value;
}

std::string nameOf(const XMLElement& element) {
  const std::string name = attribute(element, "name");
  if (name.empty()) fail(element, std::string("a ") + element.Name() + " without a name, expected one");
  return name;
}

/// Calls f(element) for each element of this name directly below another.
template <typename F>
void forEach(XMLElement& parent, const char* name, const F& f) {
  for (XMLElement *e = parent.FirstChildElement(name), *next = nullptr; e != nullptr; e = next) {
    next = e->NextSiblingElement(name);
    f(*e);
  }
}

std::vector<double> numbersOf(const XMLElement& element, const char* name, std::size_t count) {
  const auto numbers = values::numbersOf(attribute(element, name));
  if (!numbers || numbers->size() != count)
    fail(element, std::string("'") + name + "' of " + element.Name() + " is '" + attribute(element, name) +
                      "', expected " + std::to_string(count) + (count == 1 ? " number" : " numbers"));
  return *numbers;
}

std::string inWords(const Eigen::Vector3d& v) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream.precision(17);
  stream << v.x() << ' ' << v.y() << ' ' << v.z();
  return stream.str();
}

/// The root link, to which all others are joined. urdfdom leaves out links that are not, without an error.
std::string rootOf(XMLElement& robot) {
  std::map<std::string, std::string> parent;  // of each link
  std::map<std::string, const XMLElement*> links;
  forEach(robot, "link", [&](XMLElement& link) {
    if (!links.emplace(nameOf(link), &link).second)
      fail(link, "link '" + nameOf(link) + "' stands there twice");
  });
  if (links.empty()) fail(robot, "a robot without links, expected some");
  if (links.size() > max_links)
    fail(robot, std::to_string(links.size()) + " links, expected at most " + std::to_string(max_links));
  std::set<std::string> joints;
  forEach(robot, "joint", [&](XMLElement& joint) {
    const std::string name = nameOf(joint);
    if (!joints.insert(name).second) fail(joint, "joint '" + name + "' stands there twice");
    std::string ends[2];
    for (int k = 0; k < 2; ++k) {
      const char* kind = k == 0 ? "parent" : "child";
      const XMLElement* end = joint.FirstChildElement(kind);
      ends[k] = end == nullptr ? "" : attribute(*end, "link");
      if (links.count(ends[k]) == 0)
        fail(joint, "joint '" + name + "' has the " + kind + " link '" + ends[k] +
                        "', expected a link of the model");
    }
    if (!parent.emplace(ends[1], ends[0]).second)
      fail(joint, "link '" + ends[1] + "' hangs on two joints, expected one");
  });
  std::string root;
  for (const auto& [name, link] : links) {
    if (parent.count(name) > 0) continue;
    if (!root.empty()) fail(*link, "links '" + root + "' and '" + name + "' are both roots, expected one");
    root = name;
  }
  for (const auto& [name, link] : links) {
    std::size_t steps = 0;
    for (std::string at = name; parent.count(at) > 0; at = parent[at])
      if (++steps > links.size())
        fail(*link, "link '" + name + "' hangs on itself in a loop, expected a tree");
  }
  if (parent.count(world) > 0)
    fail(*links[world], "link 'world' hangs on another link, expected it to be the root");
  for (const std::string& frame : frames_of_the_rig)
    if (links.count(frame) > 0)
      fail(*links[frame], "link '" + frame + "' has the name of a frame of the rig, expected another");
  return root;
}

void hangOnWorld(XMLElement& robot, const std::string& root) {
  std::set<std::string> taken;
  forEach(robot, "joint", [&](XMLElement& joint) { taken.insert(nameOf(joint)); });
  std::string name = "world_to_" + root;
  while (taken.count(name) > 0) name += "_";
  XMLElement* joint = robot.InsertNewChildElement("joint");
  joint->SetAttribute("name", name.c_str());
  joint->SetAttribute("type", "fixed");
  joint->InsertNewChildElement("parent")->SetAttribute("link", world);
  joint->InsertNewChildElement("child")->SetAttribute("link", root.c_str());
  robot.InsertNewChildElement("link")->SetAttribute("name", world);
}

bool fixJoints(XMLElement& robot) {
  bool changed = false;
  forEach(robot, "joint", [&](XMLElement& joint) {
    const std::string type = attribute(joint, "type");
    if (type != "floating" && type != "planar") return;
    joint.SetAttribute("type", "fixed");
    changed = true;
  });
  return changed;
}

/// Puts a copy of a visual or collision beside it, with another shape at a place along its z axis.
XMLElement& addPart(XMLElement& part, XMLElement& after, const char* shape, double z) {
  XMLElement* copy = part.DeepClone(part.GetDocument())->ToElement();
  part.Parent()->InsertAfterChild(&after, copy);
  XMLElement* origin = copy->FirstChildElement("origin");
  if (origin == nullptr) origin = copy->InsertNewChildElement("origin");
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero(), rpy = xyz;
  if (origin->Attribute("xyz") != nullptr) xyz = Eigen::Vector3d(numbersOf(*origin, "xyz", 3).data());
  if (origin->Attribute("rpy") != nullptr) rpy = Eigen::Vector3d(numbersOf(*origin, "rpy", 3).data());
  const Eigen::Matrix3d turn = values::turnOf(rpy.x(), rpy.y(), rpy.z());
  origin->SetAttribute("xyz", inWords(xyz + z * turn.col(2)).c_str());
  XMLElement* geometry = copy->FirstChildElement("geometry");
  geometry->DeleteChildren();
  geometry->InsertNewChildElement(shape);
  return *copy;
}

/// Capsules as MoveIt, Drake and Bullet write them: `length` is the distance of the centres of the two
/// spheres.
bool splitCapsules(XMLElement& link, const char* kind) {
  bool changed = false;
  forEach(link, kind, [&](XMLElement& part) {
    XMLElement* geometry = part.FirstChildElement("geometry");
    const XMLElement* capsule = geometry == nullptr ? nullptr : geometry->FirstChildElement("capsule");
    if (capsule == nullptr) return;
    const double radius = numbersOf(*capsule, "radius", 1)[0], length = numbersOf(*capsule, "length", 1)[0];
    if (!(radius > 0.0 && length > 0.0))
      fail(*capsule, "a capsule without size, expected radius and length above zero");
    const std::string width = attribute(*capsule, "radius"), height = attribute(*capsule, "length");
    XMLElement* last = &part;
    for (const double end : {-0.5 * length, 0.0, 0.5 * length}) {
      last = &addPart(part, *last, end == 0.0 ? "cylinder" : "sphere", end);
      XMLElement* shape = last->FirstChildElement("geometry")->FirstChildElement();
      shape->SetAttribute("radius", width.c_str());
      if (end == 0.0) shape->SetAttribute("length", height.c_str());
    }
    link.DeleteChild(&part);
    changed = true;
  });
  return changed;
}

/// The address of a path; characters that have a meaning in addresses are coded.
std::string addressOf(const fs::path& path) {
  std::string address = "file://";
  for (const char c : path.string()) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                       std::string("/._-~+,=@:!").find(c) != std::string::npos;
    constexpr char digits[] = "0123456789ABCDEF";
    const auto byte = static_cast<unsigned char>(c);
    address += plain ? std::string(1, c) : std::string{'%', digits[byte / 16], digits[byte % 16]};
  }
  return address;
}

/// Replaces relative names of files by addresses. rviz and other readers that do not know the folder need
/// them.
bool nameFiles(XMLElement& element, const fs::path& folder) {
  bool changed = false;
  for (XMLElement* e = element.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    const std::string name = attribute(*e, "filename"), kind = e->Name();
    if ((kind == "mesh" || kind == "texture") && !name.empty() && name.find("://") == std::string::npos) {
      e->SetAttribute("filename", addressOf(fs::absolute(pathOf(name, folder)).lexically_normal()).c_str());
      changed = true;
    }
    changed = nameFiles(*e, folder) || changed;
  }
  return changed;
}

}  // namespace

std::string readyModel(const std::string& xml, const fs::path& folder) {
  if (xml.size() > files::maximum::text)
    throw std::runtime_error("urdf: is too large, expected at most 16 MiB");
  tinyxml2::XMLDocument document;
  document.Parse(xml.data(), xml.size());
  if (document.ErrorID() == tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED)
    throw std::runtime_error("urdf: elements lie more than " + std::to_string(TINYXML2_MAX_ELEMENT_DEPTH) +
                             " deep in each other, expected fewer");
  if (document.Error())
    throw std::runtime_error("urdf: line " + std::to_string(document.ErrorLineNum()) +
                             ": the robot model cannot be read, expected URDF XML: " + document.ErrorName());
  XMLElement* robot = document.RootElement();
  if (robot == nullptr || std::string(robot->Name()) != "robot")
    throw std::runtime_error(
        std::string("urdf: the robot model cannot be read, expected URDF XML with the element robot") +
        (robot == nullptr ? "" : std::string(", not ") + robot->Name()));
  const std::string root = rootOf(*robot);
  bool changed = fixJoints(*robot);
  forEach(*robot, "link", [&](XMLElement& link) {
    for (const char* kind : {"visual", "collision"}) changed = splitCapsules(link, kind) || changed;
  });
  changed = nameFiles(*robot, folder) || changed;
  if (root != world) {
    hangOnWorld(*robot, root);
    changed = true;
  }
  if (!changed) return xml;
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

std::string loadRobotModel(const std::string& file) {
  try {
    std::string xml = decodedXml(files::readWhole(file, files::maximum::text), file);
    if (hasMacros(xml, file)) xml = decodedXml(expandMacros(file), file);
    return readyModel(xml, fs::path(file).parent_path());
  } catch (const std::runtime_error& error) {
    const std::string what = error.what();
    throw std::runtime_error(what.compare(0, file.size(), file) == 0 ? what : file + ": " + what);
  }
}

}  // namespace tactile_clay::scene
