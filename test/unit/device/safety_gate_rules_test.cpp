#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "device/safety_gate.h"
#include "gates.h"

namespace tactile_clay::device::safety_gate_rules_test {
namespace {

TEST(SafetyGate, IsTightenedWhileItRunsAndNeverMadeLessStrict) {
  SafetyGateConfig config;
  config.pressure_cap = 1500.0;
  const auto of = [](double cap) {  // an instrument that tells a cap as its loudness
    return instrument([cap](const Points&) { return Loudness{cap, 0.0, ""}; });
  };
  SafetyGate gate(config, of(1500.0));
  gate.start();
  SafetyGateConfig stricter = config;
  stricter.pressure_cap = 1000.0;
  stricter.stale_timeout = 0.05;
  gate.tighten(stricter, of(1000.0));
  EXPECT_EQ(gate.config().pressure_cap, 1000.0);
  EXPECT_FALSE(gate.tick(0.06).passes());
  EXPECT_TRUE(gate.check(emission(point(0, 0, 0.2)), now()).passes());  // by the new instrument
  gate.tighten(config, of(1500.0));                                     // as at the start
  EXPECT_TRUE(gate.tick(0.06).passes());
  for (const Limit& limit : limits) {
    SafetyGateConfig half = config;
    half.*limit.value *= 0.5;
    SafetyGate strict(half, of(1500.0));
    try {
      strict.tighten(config, of(1500.0));
      FAIL() << limit.name;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(limit.name), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("never made less strict"), std::string::npos) << error.what();
    }
    EXPECT_EQ(strict.config().*limit.value, half.*limit.value);
  }
  SafetyGateConfig wider = config;
  wider.high.z() += 0.1;
  EXPECT_THROW(gate.tighten(wider, of(1500.0)), std::invalid_argument);
  SafetyGateConfig without = config;
  without.without = {Rule::hand_lost};
  EXPECT_THROW(gate.tighten(without, of(1500.0)), std::invalid_argument);
}

TEST(SafetyGate, RefusesBadSettingsByName) {
  const auto message = [](auto change) {
    SafetyGateConfig config;
    change(config);
    try {
      TestGate gate(config);
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message([](auto&) {}), "accepted");
  EXPECT_EQ(message([](auto& c) { c.stale_timeout = 0.0; }),
            "safety gate: stale_timeout (s): expected a finite number above 0, got 0");
  EXPECT_NE(message([](auto& c) { c.low.y() = 0.3; }).find("workspace in y is 0.3 to 0.2"),
            std::string::npos);
  EXPECT_NE(message([](auto& c) { c.low.x() = -100.0; }).find("workspace in x is -100 to"),
            std::string::npos);
  EXPECT_NE(message([](auto& c) { c.high.z() = nan; }).find("workspace in z"), std::string::npos);
  EXPECT_EQ(message([](auto& c) { c.intensity_cap = 1.1; }),
            "safety gate: intensity_cap: expected a number from 0 to 1, got 1.1");
  EXPECT_NE(message([](auto& c) { c.intensity_slew = 0.0; }).find("intensity_slew"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.pressure_cap = nan; }).find("pressure_cap"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.head_spl_cap = nan; }).find("head_spl_cap"), std::string::npos);
}

/// Each rule against an emission that only it objects to.
struct Offence {
  Rule rule;
  std::function<Verdict(TestGate&)> commit;  // given a started gate
};

Verdict atOnce(TestGate& gate, const Emission& e, const Occasion& occasion = now()) {
  return gate.check(e, occasion, quiet);
}

const std::vector<Offence>& offences() {
  static const std::vector<Offence> all = {
      {Rule::emergency_stop,
       [](TestGate& gate) {
         gate.stop();
         return atOnce(gate, emission(point(0, 0, 0.2)));
       }},
      {Rule::stale,
       [](TestGate& gate) {
         Occasion occasion = now();
         occasion.age = 0.15;
         return atOnce(gate, emission(point(0, 0, 0.2)), occasion);
       }},
      {Rule::hand_lost,
       [](TestGate& gate) {
         Occasion occasion = now();
         occasion.hands_tracked = false;
         return atOnce(gate, emission(point(0, 0, 0.2)), occasion);
       }},
      {Rule::modulation,
       [](TestGate& gate) {
         Emission e = emission(point(0, 0, 0.2));
         e.modulation_frequency = 2000.0;
         return atOnce(gate, e);
       }},
      {Rule::non_finite, [](TestGate& gate) { return atOnce(gate, emission(point(nan, 0, 0.2))); }},
      {Rule::workspace, [](TestGate& gate) { return atOnce(gate, emission(point(0, 0, 0.5))); }},
      {Rule::intensity, [](TestGate& gate) { return atOnce(gate, emission(point(0, 0, 0.2, 1.2))); }},
      {Rule::slew, [](TestGate& gate) { return atOnce(gate, emission(point(0, 0, 0.2, 0.9)), now(0.01)); }},
      {Rule::pressure,
       [](TestGate& gate) {
         return gate.check(emission(point(0, 0, 0.2)), now(), [](const Points&) {
           return Loudness{5000.0, 0.0, ""};
         });
       }},
      {Rule::head_level,
       [](TestGate& gate) {
         return gate.check(emission(point(0, 0, 0.2)), now(), [](const Points&) {
           return Loudness{0.0, 130.0, ""};
         });
       }},
  };
  return all;
}

/// Whether it sounds as strongly as asked for.
bool soundsFully(const Verdict& verdict) {
  return verdict.passes() && !verdict.sound.emission.points.empty() && verdict.lowered.empty();
}

TEST(SafetyGate, EachRuleIsTheOnlyOneThatHoldsItsOffenceBack) {
  for (const Offence& offence : offences()) {
    SCOPED_TRACE(nameOf(offence.rule));
    const auto soundsWithout = [&](const std::set<Rule>& without) {
      SafetyGateConfig config;
      config.without = without;
      TestGate gate(config);
      gate.start();
      return soundsFully(offence.commit(gate));
    };
    EXPECT_FALSE(soundsWithout({})) << "the whole gate";
    EXPECT_TRUE(soundsWithout({offence.rule})) << "the gate without this rule";
    std::set<Rule> others;
    for (const Offence& other : offences())
      if (other.rule != offence.rule) others.insert(other.rule);
    EXPECT_FALSE(soundsWithout(others)) << "the gate with this rule only";
  }
}

TEST(SafetyGate, RulesHaveNames) {
  for (const Offence& offence : offences()) EXPECT_EQ(ruleOf(nameOf(offence.rule)), offence.rule);
  EXPECT_EQ(nameOf(Rule::head_level), "head_level");
  try {
    ruleOf("head");
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("unknown rule 'head', expected one of emergency_stop"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace tactile_clay::device::safety_gate_rules_test
