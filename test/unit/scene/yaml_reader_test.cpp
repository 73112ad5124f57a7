#include "scene/yaml_reader.h"

#include <ctime>

#include "scene/scene.h"
#include "support/error_of.h"
#include "support/scratch_folder.h"

namespace tactile_clay::scene::yaml_reader_test {
namespace {

const std::string share = TACTILE_CLAY_SHARE;
const std::string start = "urdf: table.urdf\nspacing: 0.005\n";
const std::string body = "{name: a, material: dough, shape: box, size: [0.02, 0.02, 0.02]";

class YamlAsPeopleWriteIt : public ScratchFolder {
 protected:
  Scene load(const std::string& text) const { return loadScene(write("scene.yaml", text), share); }
  std::string complaint(const std::string& text) const {
    return errorOf([&] { load(text); });
  }
  void expectComplaint(const std::string& text, const std::string& words) const {
    const std::string said = complaint(text);
    EXPECT_NE(said.find("scene.yaml" + words), std::string::npos) << text << "\nsaid: " << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
};

TEST_F(YamlAsPeopleWriteIt, MergeKeysGiveWhatAMapHasNotItself) {
  const Scene scene =
      load(start + "bodies:\n  - &cube " + body + ", color: [0.1, 0.2, 0.3]}\n" +
           "  - &moved {<<: *cube, name: b, pose: [0.05, 0, 0, 0, 0, 0]}\n"
           "  - {<<: [{color: [0.5, 0.5, 0.5]}, *moved], name: c, pose: [-0.05, 0, 0, 0, 0, 0]}\n");
  ASSERT_EQ(scene.particles.size(), 3u * 64u);
  EXPECT_EQ(scene.bodies[1].name, "b");
  EXPECT_FLOAT_EQ(scene.bodies[1].color.z(), 0.3f);
  EXPECT_FLOAT_EQ(scene.bodies[2].color.z(), 0.5f);  // the first of several counts
  EXPECT_GT(scene.particles[64].position.x(), 0.03f);
  EXPECT_LT(scene.particles[128].position.x(), -0.03f);
}

TEST_F(YamlAsPeopleWriteIt, MergeKeysOfWhatIsNoMapAreRefused) {
  expectComplaint(start + "bodies:\n  - {<<: 3, name: a}\n", ":4: merge key '<<'");
  expectComplaint(start + "bodies:\n  - {<<: [3], name: a}\n", ":4: merge key '<<'");
  expectComplaint(start + "bodies:\n  - &a {<<: *a, name: a}\n", ":4: an alias of what it stands in");
  expectComplaint(start + "bodies:\n  - {<<: *a, name: a}\n", ":4: not YAML");
}

TEST_F(YamlAsPeopleWriteIt, AnglesMayBeDegrees) {
  const auto turned = [&](const std::string& yaw) {
    return load(start + "bodies:\n  - " + body + ", pose: [0, 0, 0, 0, 0, " + yaw + "]}\n")
        .particles[3]
        .position;
  };
  EXPECT_TRUE(turned("!degrees 90").isApprox(turned("1.5707963267948966"), 1e-6f));
  EXPECT_TRUE(turned("!radians 0.5").isApprox(turned("0.5"), 1e-6f));
  EXPECT_FALSE(turned("!degrees 90").isApprox(turned("0"), 1e-3f));
}

TEST_F(YamlAsPeopleWriteIt, OtherTagsAreRefusedWithTheirLine) {
  expectComplaint(start + "bodies:\n  - " + body + ",\n     pose: [!degrees 90, 0, 0, 0, 0, 0]}\n",
                  ":5: tag '!degrees' at 'pose'");
  expectComplaint(start + "world: !degrees 1\nbodies:\n  - " + body + "}\n", ":3: tag '!degrees' at 'world'");
  expectComplaint(start + "bodies:\n  - !body " + body + "}\n", ":4: tag '!body' is unknown");
  expectComplaint(start + "bodies: !!set\n  - " + body + "}\n", ":3: tag 'tag:yaml.org,2002:set' is unknown");
  expectComplaint(start + "world: !metres 1\nbodies:\n  - " + body + "}\n", ":3: tag '!metres' is unknown");
  expectComplaint(start + "bodies:\n  - " + body + ", pose: [0, 0, 0, 0, 0, !degrees pi]}\n",
                  ":4: tag '!degrees'");
  EXPECT_EQ(complaint(start + "world: !!float 1\nbodies:\n  - " + body + "}\n"), "");
}

TEST_F(YamlAsPeopleWriteIt, AFileHasOneDocument) {
  const std::string scene = start + "bodies:\n  - " + body + "}\n";
  EXPECT_EQ(complaint("%YAML 1.2\n---\n" + scene + "...\n"), "");
  expectComplaint(scene + "---\n" + scene, ":5: a second document");
  expectComplaint(scene + "---\n", ":5: a second document");
  expectComplaint("", ": is empty, expected a file");
  expectComplaint("# nothing yet\n", ": is empty, expected a map");
}

TEST_F(YamlAsPeopleWriteIt, ListsWhoseEntriesAreCommentedOutAreEmpty) {
  const Scene scene =
      load(start + "motions:\n#  - {joint: wheel_joint, velocity: 1}\n\nbodies:\n  - " + body + "}\n");
  EXPECT_TRUE(scene.motions.empty());
  expectComplaint(start + "bodies:\n#  - " + body + "}\nworld: 1\n", ":3: no clay");
  expectComplaint(start + "bodies:\n  -\n  - " + body + "}\n", ":3: 'bodies' has an entry without a value");
}

TEST_F(YamlAsPeopleWriteIt, ValuesThatAreMissingAreToldWithTheLineOfTheirKey) {
  expectComplaint("spacing:\n\n\nurdf: table.urdf\nbodies:\n  - " + body + "}\n",
                  ":1: 'spacing' has no value");
  expectComplaint("spacing: 0.005\nurdf: ~\nbodies:\n  - " + body + "}\n", ":2: 'urdf' has no value");
  expectComplaint(start + "bodies:\n  - " + body + ", pose: }\n", ":4: 'pose' has no value");
}

TEST_F(YamlAsPeopleWriteIt, NumbersAreNumbers) {
  for (const std::string number : {"1,5", "1.5 m", "0x10", "true", "yes", "1_000", "'", "[1]", "--1", "+-1",
                                   "1e", "inf", "1e999", "one", "{a: 1}", "\"\""}) {
    const std::string said = complaint(start + "world: " + number + "\nbodies:\n  - " + body + "}\n");
    EXPECT_NE(said.find("scene.yaml:3: "), std::string::npos) << number << ": " << said;
  }
  for (const std::string number : {"1", "1.", "01", "1.0e0", "+1", "1E0", "\"1\""})
    EXPECT_EQ(load(start + "world: " + number + "\nbodies:\n  - " + body + "}\n").config.world, 1.0)
        << number;
  expectComplaint(start + "bodies:\n  - {name: a, material: dough, shape: box, size: [0,02, 0,02, 0,02]}\n",
                  ":4: 'size' has 6 numbers");
}

/// PyYAML, by which rosparam reads, takes fewer texts for numbers, and some for others.
TEST_F(YamlAsPeopleWriteIt, NumbersForRosparamAreTheSameForBoth) {
  const auto loaded = [&](const std::string& value, YamlReaders readers) {
    return errorOf([&] { loadYaml(write("rig.yaml", "a: 1\nb: " + value + "\n"), readers); });
  };
  for (const char* value : {"110", "-3", "0.3", "-0.15", ".5", "1.", "3.0e-1", "[0, 0.5, deg(90)]",
                            "!degrees 90", "\"0 0 1\"", "word"})
    EXPECT_EQ(loaded(value, YamlReaders::rosparam_too), "") << value;
  const std::vector<std::pair<const char*, const char*>> others = {{"3e-1", "write 0.3,"},
                                                                   {"-.15", "write -0.15,"},
                                                                   {"010", "write 10,"},
                                                                   {"1e20", "write 1.0e+20,"},
                                                                   {"3000000000", "write 3000000000.0,"},
                                                                   {"1_000", "such as 0.3,"},
                                                                   {"0x10", "such as 0.3,"},
                                                                   {"1:30", "such as 0.3,"},
                                                                   {"\"110\"", "write 110,"},
                                                                   {"'0.5'", "write 0.5,"},
                                                                   {"!!str 20", "write 20,"},
                                                                   {"!!float 20", "write 20,"},
                                                                   {"\"deg(90)\"", "deg(90),"}};
  for (const auto& [value, words] : others)
    for (const std::string& text : {std::string(value), "[0, " + std::string(value) + "]"}) {
      EXPECT_EQ(loaded(text, YamlReaders::own), "") << text;
      const std::string said = loaded(text, YamlReaders::rosparam_too);
      EXPECT_NE(said.find("rig.yaml:2: '"), std::string::npos) << text << ": " << said;
      EXPECT_NE(said.find(words), std::string::npos) << text << ": " << said;
    }
  EXPECT_EQ(loaded(std::string(100000, '1'), YamlReaders::rosparam_too).find('\n'), std::string::npos);
}

TEST_F(YamlAsPeopleWriteIt, WholeNumbersAreWholeAndInRange) {
  YamlMap map = loadYaml(write("numbers.yaml", "a: 3\nb: 3.5\nc: 1e12\nd: -1\ne: 010\n"));
  EXPECT_EQ(map.get<int>("a", "a whole number"), 3);
  EXPECT_EQ(map.get<int>("e", "a whole number"), 10);
  EXPECT_THROW(map.get<int>("b", "a whole number"), std::runtime_error);
  EXPECT_THROW(map.get<int>("c", "a whole number"), std::runtime_error);
  EXPECT_THROW(map.get<unsigned>("d", "a whole number"), std::runtime_error);
}

TEST_F(YamlAsPeopleWriteIt, TabsAndLatin1AreToldWithTheirLine) {
  expectComplaint(start + "bodies:\n\t- " + body + "}\n", ":4: not YAML");
  expectComplaint(start + "# T\xf6pfe\nbodies:\n  - " + body + "}\n", ":3: bytes that are no UTF-8");
  EXPECT_EQ(complaint("\xef\xbb\xbf" + start + "bodies:\n  - " + body + "}\n"), "");
}

TEST_F(YamlAsPeopleWriteIt, AliasesDoNotMultiply) {
  std::string bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int k = 1; k < 12; ++k) {
    const std::string before = "*a" + std::to_string(k - 1);
    bomb += "a" + std::to_string(k) + ": &a" + std::to_string(k) + " [" + before;
    for (int n = 1; n < 10; ++n) bomb += ", " + before;
    bomb += "]\n";
  }
  expectComplaint(bomb, ":6: more than 200000 values");
  std::string merges = "m0: &m0 {b: 1}\n";
  for (int k = 1; k < 40; ++k) {
    const std::string before = "*m" + std::to_string(k - 1);
    merges +=
        "m" + std::to_string(k) + ": &m" + std::to_string(k) + " {<<: [" + before + ", " + before + "]}\n";
  }
  expectComplaint(merges, ":16: more than 200000 values");
}

// A step per pair of keys would take a hundred times as long for ten times as many keys.
TEST_F(YamlAsPeopleWriteIt, WideMapsAreReadKeyByKey) {
  const auto processorTime = [&](std::size_t count) {
    std::string wide;
    for (std::size_t k = 0; k < count; ++k) wide += "k" + std::to_string(k) + ": 1\n";
    const std::clock_t begin = std::clock();
    EXPECT_EQ(loadYaml(write("wide.yaml", wide)).keys().size(), count);
    return static_cast<double>(std::clock() - begin);
  };
  const double few = processorTime(9900);
  EXPECT_LT(processorTime(99000), 40.0 * few);
}

TEST_F(YamlAsPeopleWriteIt, DeepNestingEndsWithOneLine) {
  for (const char* opening : {"[", "{a: ", "- "}) {
    std::string deep = "a: \n ";
    for (int k = 0; k < 100000; ++k) deep += opening;
    const std::string said = complaint(deep);
    EXPECT_NE(said.find("scene.yaml:"), std::string::npos) << said.substr(0, 200);
  }
}

}  // namespace
}  // namespace tactile_clay::scene::yaml_reader_test
