// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/law_facts.hpp"

#include <cmath>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(LawFacts) {
  IdentifyResult result;
  void setup() override {
    result.model.laws = assumed_laws(25.0);
    result.packed = Eigen::VectorXd::Zero(100);
    set_sigma(4.0);
  }
  void set_sigma(double sigma) { result.uncertainty.sigma = Eigen::VectorXd::Constant(result.packed.size(), sigma); }
  const LawFact& ohmic(const std::vector<LawFact>& facts) { return facts.at(0); }
};

TEST(LawFacts, EnergiesAreReadInKilojoulesWithTheirInterval) {
  const std::string text = laws_text(result);
  STRCMP_CONTAINS("R0 with temperature          15 kJ/mol measured  7.16 to 22.84\n", text.c_str());
  STRCMP_EQUAL("identified, 7.16 to 22.84 kJ/mol", law_origin(law_facts(result), "r0_activation_energy").c_str());
}

TEST(LawFacts, WithoutAnIntervalTheTextSaysSoAndNoEndIsMadeUp) {
  set_sigma(std::nan(""));
  const std::vector<LawFact> facts = law_facts(result);
  CHECK(std::isnan(ohmic(facts).ci95_low) && std::isnan(ohmic(facts).ci95_high));
  CHECK(ohmic(facts).origin == FactOrigin::kAssumed);
  const std::string text = laws_text(result);
  STRCMP_CONTAINS("R0 with temperature          15 kJ/mol assumed   not settled\n", text.c_str());
  CHECK(text.find("nan") == std::string::npos);
  STRCMP_EQUAL("assumed, not settled", law_origin(facts, "r0_activation_energy").c_str());
}
