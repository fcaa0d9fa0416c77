// SPDX-License-Identifier: Apache-2.0
#include "stopwatch.hpp"

#include <benchmark/benchmark.h>

#include <ctime>

#include "reference_kernel.hpp"

namespace voltlap::benchmarks {
namespace {

double processor_ns() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e9 + static_cast<double>(now.tv_nsec);
}

double timed_reference_ns() {
  const double begin = processor_ns();
  benchmark::DoNotOptimize(reference_kernel());
  return processor_ns() - begin;
}

}  // namespace

void Stopwatch::start() {
  stretches_.clear();
  reference_ns_ = timed_reference_ns();
  resumed_ns_ = processor_ns();
}

void Stopwatch::split() {
  const double work_ns = processor_ns() - resumed_ns_;
  const double before_ns = reference_ns_;
  reference_ns_ = timed_reference_ns();
  stretches_.push_back({work_ns, 0.5 * (before_ns + reference_ns_)});
  resumed_ns_ = processor_ns();
}

}  // namespace voltlap::benchmarks
