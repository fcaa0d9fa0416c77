// SPDX-License-Identifier: Apache-2.0
#include "measure.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <regex>

#include "core/errors.hpp"
#include "workloads.hpp"

namespace voltlap::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

/// What a row has gathered so far.
struct Gathered {
  Workload workload;
  int planned = 0;
  Amount amount{};
  Repetitions repetitions{};
};

/// The library's own report is of no use here: its averages are not what is compared.
class Silent : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>&) override {}
};

class Progress {
 public:
  explicit Progress(int planned) : planned_(planned) {}
  void advance() {
    ++done_;
    if (Clock::now() - shown_ < (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(5000))) return;
    shown_ = Clock::now();
    fmt::print(stderr, "{}measuring: {:3} %{}", terminal_ ? "\r" : "", 100 * done_ / planned_, terminal_ ? "" : "\n");
    std::fflush(stderr);
  }
  ~Progress() {
    if (terminal_) std::fputs("\r                    \r", stderr);
  }

 private:
  int planned_, done_ = 0;
  bool terminal_ = ::isatty(STDERR_FILENO) == 1;
  Clock::time_point shown_ = Clock::now();
};

std::vector<Gathered> chosen(const Plan& plan) {
  std::vector<Gathered> rows;
  std::vector<std::string> names;
  std::regex filter;
  try {
    filter = std::regex(plan.filter);
  } catch (const std::regex_error& error) {
    throw plant::InputError("--filter " + plan.filter, fmt::format("no regular expression ({})", error.what()),
                            "a regular expression on the names", "Correct it");
  }
  constexpr int kQuickShare = 3, kLeast = 4;
  for (Workload& workload : workloads()) {
    names.push_back(workload.name);
    if (!std::regex_search(workload.name, filter)) continue;
    const int planned = plan.quick ? std::max(kLeast, workload.repetitions / kQuickShare) : workload.repetitions;
    rows.push_back({std::move(workload), planned});
  }
  if (rows.empty()) {
    throw plant::InputError("--filter " + plan.filter, "nothing that it matches",
                            fmt::format("one of {}", fmt::join(names, ", ")), "Correct it, or leave the flag out");
  }
  return rows;
}

void run_once(benchmark::State& state, Gathered& row, Progress& progress) {
  for (auto _ : state) {
    Stopwatch watch;
    row.amount = row.workload.run(watch);
    double work_ns = 0.0;
    for (const Stretch& stretch : watch.stretches()) work_ns += stretch.work_ns;
    state.SetIterationTime(work_ns * 1e-9);
    row.repetitions.push_back(watch.stretches());
  }
  progress.advance();
}

Row row_of(const Gathered& gathered, double reference_ns) {
  Row row{.name = gathered.workload.name,
          .operation = gathered.workload.operation,
          .repetitions = static_cast<int>(gathered.repetitions.size()),
          .estimate = estimate(gathered.repetitions, gathered.amount.operations, reference_ns)};
  row.sim_s_per_s = gathered.amount.simulated_s / gathered.amount.operations / (row.estimate.ns * 1e-9);
  return row;
}

}  // namespace

Measurement measure(const Plan& plan) {
  std::vector<Gathered> rows = chosen(plan);
  int planned = 0;
  for (const Gathered& row : rows) planned += row.planned;
  {
    Progress progress(planned);
    char program[] = "benchmark", mixed[] = "--benchmark_enable_random_interleaving=true";
    char* arguments[] = {program, mixed, nullptr};
    int count = 2;
    benchmark::Initialize(&count, arguments);
    for (Gathered& row : rows) {
      benchmark::RegisterBenchmark(row.workload.name.c_str(),
                                   [&](benchmark::State& state) { run_once(state, row, progress); })
          ->Iterations(1)
          ->Repetitions(row.planned)
          ->UseManualTime();
    }
    Silent silent;
    benchmark::RunSpecifiedBenchmarks(&silent, "all");
    benchmark::ClearRegisteredBenchmarks();
  }
  std::vector<Repetitions> all;
  for (const Gathered& row : rows) all.push_back(row.repetitions);
  Measurement out{.machine = this_machine(), .reference_ns = reference_time_ns(all), .rows = {}};
  for (const Gathered& row : rows) out.rows.push_back(row_of(row, out.reference_ns));
  return out;
}

}  // namespace voltlap::benchmarks
