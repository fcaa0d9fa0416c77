// SPDX-License-Identifier: Apache-2.0
// An identification of the virtual bench's data beside the truth that made them: error, interval and coverage map of
// every node.
//
// SOC of a fit counts charge: 1 where the recording begins full, 0 where it has drawn most. The truth is taken at the
// cell's own SOC of the same charge, and at the current that flowed there.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "learn/bench/campaign.hpp"
#include "learn/identify/cell_identification.hpp"

namespace voltlap::known_truth {

inline constexpr int kTables = 6;
inline constexpr std::array<const char*, kTables> kNames{"Em", "R0", "R1", "R2", "tau1", "tau2"};
/// The marks: what the fit promises where a node is passed and its interval is narrower than this: V; relative.
inline constexpr std::array<double, kTables> kPromised{2e-3, 0.01, 0.05, 0.05, 0.10, 0.10};

struct Node {
  int table = 0;
  double soc = 0.0, error = 0.0, half_width = 0.0;  ///< V for Em, else of the logarithm; 95 %
  bool excited = false;  ///< its interval is narrower than the mark
};

struct Case {
  std::vector<std::string> settings;  ///< of the plan
  std::string plan = "pulse_long_rests";
  bool limits_stated = false;  ///< the fit is told the instruments' limits
  std::string cell = "aesc_e5_2p";  ///< the truth: name or file
};

struct Outcome {
  std::vector<Node> nodes;
  double mean_square_v2 = 0.0, seconds = 0.0;
  std::string smoothness_from;
};

[[nodiscard]] plant::CellLog log_of(const plant::BenchRecord& record, std::size_t cell);
/// Test `test` of a campaign with this seed, one of its cells identified.
[[nodiscard]] Outcome run_case(const Case& one, std::uint64_t seed, std::size_t test, std::size_t cell);

/// Counts over many outcomes, table by table.
struct Tally {
  struct Row {
    int nodes = 0, excited = 0, within = 0, covered = 0, covered_all = 0;
    double widest = 0.0, worst = 0.0, square = 0.0;  ///< of excited nodes: half width; error; sum of squared errors
  };
  std::array<Row, kTables> rows;
  int outcomes = 0, by_evidence = 0;
  double mean_square_v2 = 0.0, seconds = 0.0;

  void add(const Outcome& outcome);
  [[nodiscard]] Row all() const;
};
[[nodiscard]] std::string text_of(const Tally& tally);

}  // namespace voltlap::known_truth
