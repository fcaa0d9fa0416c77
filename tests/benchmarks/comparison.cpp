// SPDX-License-Identifier: Apache-2.0
#include "comparison.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "quantities.hpp"

namespace voltlap::benchmarks {
namespace {

const char* verdict_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::kSlower: return "SLOWER";
    case Verdict::kFaster: return "faster";
    case Verdict::kNew: return "new";
    case Verdict::kNotMeasured: return "not measured";
    case Verdict::kAsBefore: break;
  }
  return "as before";
}

const Row* find(const Measurement& measurement, const std::string& name) {
  const auto row =
      std::find_if(measurement.rows.begin(), measurement.rows.end(), [&](const Row& r) { return r.name == name; });
  return row == measurement.rows.end() ? nullptr : &*row;
}

ComparedRow compared(const Row& earlier, const Row& now) {
  ComparedRow row{.name = now.name, .earlier_ns = earlier.estimate.ns, .now_ns = now.estimate.ns};
  row.ratio = now.estimate.relative / earlier.estimate.relative;
  row.low = std::min(row.ratio, now.estimate.low / earlier.estimate.high);
  row.high = std::max(row.ratio, now.estimate.high / earlier.estimate.low);
  if (row.low > kThreshold) row.verdict = Verdict::kSlower;
  if (row.high < 1.0 / kThreshold) row.verdict = Verdict::kFaster;
  return row;
}

std::string difference(const char* what, const std::string& earlier, const std::string& now) {
  return earlier == now ? "" : fmt::format("  {} differs: {} earlier, {} now\n", what, earlier, now);
}

}  // namespace

std::vector<ComparedRow> compare(const Measurement& earlier, const Measurement& now) {
  std::vector<ComparedRow> rows;
  for (const Row& row : now.rows) {
    const Row* before = find(earlier, row.name);
    rows.push_back(before != nullptr
                       ? compared(*before, row)
                       : ComparedRow{.name = row.name, .now_ns = row.estimate.ns, .verdict = Verdict::kNew});
  }
  for (const Row& row : earlier.rows) {
    if (find(now, row.name) == nullptr) {
      rows.push_back({.name = row.name, .earlier_ns = row.estimate.ns, .verdict = Verdict::kNotMeasured});
    }
  }
  return rows;
}

bool any_slower(const std::vector<ComparedRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const ComparedRow& row) { return row.verdict == Verdict::kSlower; });
}

std::string comparison_text(const Measurement& earlier, const Measurement& now, const std::vector<ComparedRow>& rows) {
  std::string out =
      fmt::format("{:<26}{:>10}{:>10}{:>8}   {:<14}{}\n", "", "earlier", "now", "ratio", "interval", "verdict");
  for (const ComparedRow& row : rows) {
    const bool both = row.earlier_ns > 0.0 && row.now_ns > 0.0;
    out += fmt::format("{:<26}{:>10}{:>10}{:>8}   {:<14}{}\n", row.name,
                       row.earlier_ns > 0.0 ? time_text(row.earlier_ns) : "-",
                       row.now_ns > 0.0 ? time_text(row.now_ns) : "-", both ? fmt::format("{:.2f}", row.ratio) : "-",
                       both ? fmt::format("{:.2f} .. {:.2f}", row.low, row.high) : "", verdict_text(row.verdict));
  }
  out += fmt::format("ratio: now over earlier, each in units of the reference kernel ({} earlier, {} now)\n"
                     "slower, faster: the whole interval lies beyond a factor of {:.2f}\n",
                     time_text(earlier.reference_ns), time_text(now.reference_ns), kThreshold);
  out += difference("cpu", earlier.machine.cpu, now.machine.cpu);
  out += difference("compiler", earlier.machine.compiler, now.machine.compiler);
  out += difference("build type", earlier.machine.build_type, now.machine.build_type);
  out += difference("flags", earlier.machine.flags, now.machine.flags);
  out += difference("version", earlier.machine.version, now.machine.version);
  return out;
}

}  // namespace voltlap::benchmarks
