// SPDX-License-Identifier: Apache-2.0
// ./voltlap known-truth: many bench tests of known cells, each identified, and how the answers stand to the truth.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <mutex>
#include <thread>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/guarded_main.hpp"
#include "comparison.hpp"

namespace {

using namespace voltlap::known_truth;

constexpr const char* kExplanation =
    "Each seed draws four unequal cells and the noise; one of the cells is identified, another one for each seed.\n"
    "Excited: the interval is narrower than the mark (2 mV; 1 % R0;\n"
    "5 % R1, R2; 10 % tau). Covered: the truth lies inside the 95 % interval.\n"
    "Example: ./voltlap known-truth --seeds 20\n"
    "Exit code: 0 done, 2 usage or input.";

struct Flags {
  int seeds = 200, test = 0, threads = 2;
  Case one{{"instruments.systematic=false", "box.mode=bath"}, "pulse_long_rests"};
  std::vector<std::string> settings;
  bool systematic = false;
};

/// All seeds on several threads; the first failure ends them.
Tally tally_of(const Flags& flags) {
  Tally tally;
  std::mutex mutex;
  std::atomic<int> next{0};
  std::exception_ptr failed;
  const auto work = [&] {
    try {
      for (int k = next++; k < flags.seeds; k = next++) {
        const Outcome outcome = run_case(flags.one, static_cast<std::uint64_t>(k) + 1,
                                         static_cast<std::size_t>(flags.test), static_cast<std::size_t>(k) % 4);
        const std::lock_guard lock(mutex);
        tally.add(outcome);
        if (tally.outcomes % 10 == 0) fmt::print(stderr, "voltlap: {} of {}\n", tally.outcomes, flags.seeds);
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      failed = std::current_exception();
      next = flags.seeds;
    }
  };
  std::vector<std::thread> threads;
  for (int k = 0; k < flags.threads; ++k) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  if (failed) std::rethrow_exception(failed);
  return tally;
}

int run(int argc, char** argv) {
  CLI::App app("How well identify finds cells that are known.", "voltlap known-truth");
  Flags flags;
  using voltlap::plant::whole_number;
  app.add_option("--seeds", flags.seeds, "Campaigns, each with its own cells and noise")
      ->check(whole_number(1, 100000))
      ->capture_default_str();
  app.add_option("--plan", flags.one.plan, "Bench plan")->capture_default_str();
  app.add_option("--cell", flags.one.cell, "The truth: cell file or name")->capture_default_str();
  app.add_option("--test", flags.test, "Which of the plan's tests, from 0")->check(whole_number(0, 100));
  app.add_option("--threads", flags.threads, "At once")->check(whole_number(1, 256))->capture_default_str();
  app.add_option("--set", flags.settings, "key=value of the plan");
  app.add_flag("--systematic", flags.systematic, "Lasting errors of the instruments too, and their limits stated");
  app.footer(kExplanation);
  app.failure_message(voltlap::plant::usage_message);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? voltlap::plant::kExitOk : voltlap::plant::kExitInput;
  }
  if (flags.systematic) {
    flags.one.settings[0] = "instruments.systematic=true";
    flags.one.limits_stated = true;
  }
  flags.one.settings.insert(flags.one.settings.end(), flags.settings.begin(), flags.settings.end());
  fmt::print("{}", text_of(tally_of(flags)));
  return voltlap::plant::kExitOk;
}

}  // namespace

int main(int argc, char** argv) { return voltlap::plant::guarded_main(run, argc, argv); }
