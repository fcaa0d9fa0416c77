// SPDX-License-Identifier: Apache-2.0
// A measurement as JSON, and as the document docs/benchmark.md.
#pragma once
#include <string>
#include <vector>

#include "estimate.hpp"
#include "machine.hpp"

namespace voltlap::benchmarks {

struct Row {
  std::string name, operation;
  int repetitions = 0;
  double sim_s_per_s = 0.0;  ///< simulated seconds in a second of processor time
  Estimate estimate{};
};

struct Measurement {
  Machine machine;
  double reference_ns = 0.0;
  std::vector<Row> rows;
};

[[nodiscard]] std::string to_json(const Measurement& measurement);
/// Throws InputError that names the file and the field.
[[nodiscard]] Measurement read_json(const std::string& path);
[[nodiscard]] std::string to_markdown(const Measurement& measurement);

}  // namespace voltlap::benchmarks
