// SPDX-License-Identifier: Apache-2.0
// Which of the sets that stand is the answer, and which are followed along their bends for it.
#include "explain/decide/answer.hpp"

#include <CppUTest/TestHarness.h>

#include <vector>

#include "simulated_channel.hpp"

namespace voltlap::explain {
namespace {

std::vector<plant::Cause> two_causes() {
  plant::Cause wave{}, other{};
  wave.name = "wave";
  other.name = "other";
  for (plant::Cause* cause : {&wave, &other}) cause->parameters = {{"size", "1", -100.0, 100.0, 1.0}};
  return {wave, other};
}

/// One channel, a cause that is its wave and one that is a quarter of a turn later.
Family family_of(const SimulatedChannel& channel) {
  Family out;
  out.problem = channel.problem();
  for (int k = 0; k < 2; ++k) {
    Suspect suspect;
    suspect.cause = k;
    suspect.name = k == 0 ? "wave" : "other";
    suspect.form.at = {0.0};
    suspect.form.linear = suspect.form.refined = {0};
    suspect.form.apply = [](plant::World&, plant::Values) {};
    suspect.columns = {k + 1};
    out.suspects.push_back(suspect);
  }
  out.channel = {"voltage"};
  out.practical = {1.0};
  out.typical = VectorXd::Ones(3);
  return out;
}

struct Asking {
  AnswerOf answer;
  std::vector<std::vector<std::size_t>> followed;
};

Asking ask(const Family& family, const std::vector<Sound>& references) {
  const std::vector<plant::Cause> causes = two_causes();
  Search search(family, causes);
  Asking out;
  out.answer = answer_of(family, search, Asked(references), [&](const Family&, const Set& set) {
    out.followed.push_back(set.members);
    return set;
  });
  return out;
}

Family noisy(unsigned seed, double wave, double other, double slow) {
  SimulatedChannel made(seed);
  made.add_white(0.1);
  made.add_slow(slow);
  made.add(wave * made.wave() + other * made.late_wave());
  return family_of(made);
}

}  // namespace

TEST_GROUP(Answer){};

TEST(Answer, OnlyTheSetsThatTheAnswerDependsOnAreFollowed) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Asking one = ask(noisy(seed, 5.0, 0.0, 0.3), {});
    LONGS_EQUAL(1, one.answer.sets.size());
    CHECK(one.answer.sets[0].members == std::vector<std::size_t>{0});
    CHECK(one.followed == (std::vector<std::vector<std::size_t>>{{0}}));
    const Asking both = ask(noisy(seed, 5.0, 4.0, 0.3), {});
    LONGS_EQUAL(1, both.answer.sets.size());
    CHECK(both.answer.sets[0].members == (std::vector<std::size_t>{0, 1}));
    LONGS_EQUAL(3, both.followed.size());  // both together, and each of its parts
  }
}

TEST(Answer, AnErrorNoLargerThanThatOfTheWorstSoundLogIsNone) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const auto with_worst = [&](double amplitude) {
      const Family log = noisy(seed, 5.0, 0.0, 0.3);
      const Family a = noisy(seed + 100, 0.0, 0.0, 0.3), b = noisy(seed + 200, 0.0, 0.0, 0.3);
      const Family worst = noisy(seed + 300, 0.0, amplitude, 0.3);
      std::vector<Sound> references;
      for (const Family* one : {&a, &b, &worst}) {
        references.emplace_back([one](const std::vector<Suspect>&) -> const Family& { return *one; });
      }
      return ask(log, references).answer.sets.size();
    };
    LONGS_EQUAL(1, with_worst(4.0));
    LONGS_EQUAL(0, with_worst(6.0));
  }
}

}  // namespace voltlap::explain
