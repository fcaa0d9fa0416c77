// SPDX-License-Identifier: Apache-2.0
// What is said of a log: the verdict with its causes, gains and pictures.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "explain/balances/balances.hpp"

namespace voltlap::plant {

enum class Verdict { kNamed, kAmbiguous, kUnknown, kNoDiscrepancy, kBadData };
[[nodiscard]] const char* name_of(Verdict verdict);

struct FoundParameter {
  std::string name, unit;
  double value = 0.0, low = 0.0, high = 0.0;
  std::string text;          ///< where the value is a word: a channel
  double shown_scale = 1.0;  ///< for people, with
  std::string shown_unit = {};
};

struct FoundCause {
  std::string name;
  std::vector<FoundParameter> parameters;
  double share_of_residual = 0.0, probability = 0.0, d_prime = 0.0;
  std::vector<std::string> equivalent_to;
  std::string says;
};

struct ChannelGain {
  double before = 0.0, after = 0.0, floor = 0.0;
  double drop_low = 0.0,
         drop_high = 0.0;  ///< 95 % interval of 1 - after/before, by leaving out one block after the other
  std::string unit;
};

/// A set that lost, and why.
struct RunnerUp {
  std::vector<std::string> names;
  double behind = 0.0;  ///< ln evidence
  std::string why;
};

/// A channel's residual before and after, for pictures; NaN where nothing was compared.
struct Trace {
  std::string channel, unit;
  double floor = 0.0;   ///< RMS of its noise
  bool member = false;  ///< of a group: a cell or thermistor minus the mean
  Eigen::VectorXd before, after;
};

/// What went on during the log; empty where it is not known.
struct Circumstances {
  Eigen::VectorXd time_s, current_a, soc, temperature_c, speed_mps;
};

struct Explanation {
  Verdict verdict = Verdict::kNoDiscrepancy;
  std::string sentence;
  std::vector<FoundCause> causes;
  std::vector<std::vector<std::string>> alternatives;
  std::optional<Balance> unknown_in;
  std::map<std::string, ChannelGain> gain;
  std::vector<Masked> masked;
  std::string next_test;  ///< empty: none
  bool with_references = false;
  std::vector<RunnerUp> runners_up;
  std::vector<Trace> traces;
  Circumstances circumstances;
  std::vector<std::string> notes;
  std::optional<World> world;  ///< the model with the causes that were found
};

}  // namespace voltlap::plant
