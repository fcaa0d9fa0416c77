// SPDX-License-Identifier: Apache-2.0
// What a test excites: how long the cell was near each breakpoint of its tables, under load and at rest, and which
// time constants the rests are long enough to show. Near: the breakpoint is the nearest one on each axis; the
// current of a rest is that of the load before it, as in the tables' lookup.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "car/battery/cell_tables.hpp"
#include "learn/bench/bench_record.hpp"

namespace voltlap::plant {

class Coverage {
 public:
  explicit Coverage(const CellParameters& cell);

  void add(const BenchRecord& record);

  [[nodiscard]] const std::vector<double>& soc() const { return soc_; }
  [[nodiscard]] const std::vector<double>& temperature_c() const { return temperature_; }
  [[nodiscard]] const std::vector<double>& current_a() const { return current_; }
  [[nodiscard]] double load_s(std::size_t soc, std::size_t temperature, std::size_t current) const {
    return load_s_[node(soc, temperature, current)];
  }
  [[nodiscard]] double rest_s(std::size_t soc, std::size_t temperature, std::size_t current) const {
    return rest_s_[node(soc, temperature, current)];
  }
  /// Nodes with at least this much load. A node of a few seconds carries R0, hardly more.
  [[nodiscard]] std::size_t visited(double load_s_min = 1.0) const;
  [[nodiscard]] std::size_t nodes() const { return load_s_.size(); }

 private:
  [[nodiscard]] std::size_t node(std::size_t soc, std::size_t temperature, std::size_t current) const {
    return (soc * temperature_.size() + temperature) * current_.size() + current;
  }
  std::vector<double> soc_, temperature_, current_;
  std::vector<double> load_s_, rest_s_;
};

/// The rests of some tests, set against the cell's own time constants.
struct RestSummary {
  std::size_t count = 0;
  double shortest_s = 0.0, median_s = 0.0, longest_s = 0.0;
  struct TauRange {
    double min_s = 1e300, max_s = 0.0;
  };
  std::vector<TauRange> taus;             ///< of each branch, where the rests were
  std::size_t shorter_than_last_tau = 0;  ///< rests that end before the slow branch has lost 63 %
};

/// "tau1 is 3 to 5 s and its tau2 80 to 90 s".
[[nodiscard]] std::string taus_text(const RestSummary& rests);

class RestSurvey {
 public:
  explicit RestSurvey(const CellParameters& cell) : tables_(cell) { sum_.taus.resize(tables_.branches()); }
  void add(const BenchRecord& record);
  [[nodiscard]] RestSummary summary() const;

 private:
  CellTables tables_;
  RestSummary sum_;
  std::vector<double> lengths_;
};

}  // namespace voltlap::plant
