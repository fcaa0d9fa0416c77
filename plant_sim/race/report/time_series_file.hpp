// SPDX-License-Identifier: Apache-2.0
// The time series of a run as CSV: `#` lines with version, seed and parameters, one line of column names, the samples.
#pragma once
#include <string>

#include "io/atomic_file.hpp"
#include "race/report/run_result.hpp"

namespace voltlap::plant {

class TimeSeriesFile {
 public:
  static constexpr int kSamplesPerSecond = 10;  ///< as the study hands them over

  /// Writes the head. `rate_hz` is kSamplesPerSecond or an even part of it; throws InputError otherwise.
  TimeSeriesFile(const std::string& path, double rate_hz, const RunDescription& run, const VehicleParameters& car);
  void add(const TimeSample& sample);
  void complete() { file_.complete(); }
  void commit() { file_.commit(); }

 private:
  void columns(int cells);

  long long every_;  ///< one sample of so many is written
  AtomicFile file_;
  long long count_ = 0;
  std::string line_;
};

}  // namespace voltlap::plant
