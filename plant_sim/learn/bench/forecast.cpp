// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/forecast.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {

TestForecast summary_of(const BenchRecord& record) {
  VOLTLAP_DEMAND(!record.cells.empty());
  TestForecast out;
  out.test = record.test;
  out.duration_s = record.duration_s();
  out.charge_ah = record.charge_ah;
  out.pulses = record.count(true);
  out.rests = record.count(false);
  out.end = record.end;
  out.lowest_v = out.coldest_c = 1e9;
  out.hottest_c = -1e9;
  for (const CellRecord& cell : record.cells) {
    out.lowest_v = std::min(out.lowest_v, *std::min_element(cell.voltage_v.begin(), cell.voltage_v.end()));
    const auto [cold, hot] = std::minmax_element(cell.temperature_c.begin(), cell.temperature_c.end());
    out.coldest_c = std::min(out.coldest_c, *cold);
    out.hottest_c = std::max(out.hottest_c, *hot);
  }
  out.current_min_a = 1e9;
  for (const BenchPhase& phase : record.phases) {
    if (!phase.load || phase.charge_ah <= 0.0) continue;
    const double mean = 3600.0 * phase.charge_ah / (phase.end_s - phase.begin_s);
    out.current_min_a = std::min(out.current_min_a, mean);
    out.current_max_a = std::max(out.current_max_a, mean);
  }
  out.current_min_a = std::min(out.current_min_a, out.current_max_a);
  return out;
}

Forecast forecast(const Campaign& campaign, const std::function<bool(std::size_t, double)>& stop) {
  VOLTLAP_DEMAND(!campaign.tests().empty() && campaign.plan().sampling.log_hz > 0.0);
  Forecast out{{}, Coverage(campaign.cell()), {}, 1.0 / campaign.plan().sampling.log_hz, 0.0, 0.0, false};
  RestSurvey rests(campaign.cell());
  for (std::size_t i = 0; i < campaign.tests().size(); ++i) {
    const BenchRecord record =
        campaign.rehearse(i, stop ? [&stop, i](double time_s) { return stop(i, time_s); } : StopRequest{});
    if (record.end == TestEnd::kInterrupted) {
      out.interrupted = true;
      return out;
    }
    out.tests.push_back(summary_of(record));
    out.coverage.add(record);
    rests.add(record);
    out.bench_s += record.duration_s();
  }
  out.rests = rests.summary();
  out.calendar_s = out.bench_s + 3600.0 * campaign.plan().test.pause_h * static_cast<double>(out.tests.size() - 1);
  return out;
}

}  // namespace voltlap::plant
