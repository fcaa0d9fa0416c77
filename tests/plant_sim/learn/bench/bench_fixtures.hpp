// SPDX-License-Identifier: Apache-2.0
// What the bench's suites share: plans, ideal instruments, a cell with closed forms.
#pragma once
#include <string>
#include <vector>

#include "learn/bench/plan_file.hpp"
#include "learn/bench/virtual_bench.hpp"

namespace voltlap::plant::test {

/// A plan of the project, with settings.
[[nodiscard]] BenchPlan shipped_plan(const std::string& name, const std::vector<std::string>& settings = {});

/// One test of pulse_15 (30 degC, nominal current 200 A) without instrument errors, cells held at 30 degC, a row
/// for every reading.
[[nodiscard]] BenchPlan ideal_plan(const std::vector<std::string>& settings = {});

/// Parameters that depend on nothing, with an OCV of 3 V + 1.2 V SOC.
[[nodiscard]] CellParameters straight_cell();

/// One test with equal cells.
[[nodiscard]] BenchRecord run_equal(const BenchPlan& plan, const CellParameters& cell);

}  // namespace voltlap::plant::test
