// SPDX-License-Identifier: Apache-2.0
// ./voltlap benchmark: how long the pieces and the whole take, and whether a change made them slower.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/guarded_main.hpp"
#include "comparison.hpp"
#include "io/atomic_file.hpp"
#include "measure.hpp"
#include "quantities.hpp"

namespace {

using namespace voltlap::benchmarks;
using voltlap::plant::AtomicFile;

constexpr int kExitSlower = 1;
constexpr const char* kExplanation =
    "Every row does the same work again and again, the rows' repetitions mixed, with a fixed reference kernel every "
    "few\n"
    "milliseconds. A row's time is the quickest that was seen of each stretch of its work, in processor time of one "
    "core.\n"
    "--compare divides it by the reference kernel's time of the same run, so that a machine that is slower today does "
    "not\n"
    "count; the interval comes from random halves of the repetitions.\n"
    "sim_s_per_s: simulated seconds in a second of processor time; for the lap solver, lap time over time to solve "
    "it.\n"
    "A whole run takes about 20 s on a quiet machine.\n"
    "Example: ./voltlap benchmark --json before.json; change something; ./voltlap benchmark --compare before.json\n"
    "Exit code: 0 measured, and nothing is slower; 1 something is slower; 2 usage or input.";

struct Flags {
  Plan plan;
  std::string json, markdown, compare;
};

void add_flags(CLI::App& app, Flags& flags) {
  using voltlap::plant::add_output_file;
  add_output_file(app, "--json", flags.json,
                  "Write the measurement: machine, and name, ns, spread, sim_s_per_s of each row");
  app.add_option("--compare", flags.compare, "Compare with an earlier measurement, written by --json")
      ->type_name("FILE");
  app.add_option("--filter", flags.plan.filter, "Only rows whose name matches")->type_name("REGEX");
  app.add_flag("--quick", flags.plan.quick, "A third of the repetitions, at least four: less certain");
  add_output_file(app, "--markdown", flags.markdown, "Write the table for docs/benchmark.md");
  app.footer(kExplanation);
}

void print_rows(std::FILE* out, const Measurement& now) {
  fmt::print(out, "{:<26}{:>10}{:>14}{:>9}   {}\n", "", "time", "sim_s_per_s", "spread", "operation");
  for (const Row& row : now.rows) {
    fmt::print(out, "{:<26}{:>10}{:>14}{:>7.0f} %   {}\n", row.name, time_text(row.estimate.ns),
               factor_text(row.sim_s_per_s), 100.0 * row.estimate.spread, row.operation);
  }
}

/// A path that cannot be written is known before the work, and nothing of it stays when the work is broken off.
void check_writable(const std::string& path) {
  if (!path.empty()) AtomicFile probe(path);
}

void write(const std::string& path, const std::string& text) {
  if (path.empty()) return;
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

int run(int argc, char** argv) {
  CLI::App app("Measures how long a plant step, a cell step, a firmware tick, a lap and an endurance take.",
               "voltlap benchmark");
  Flags flags;
  add_flags(app, flags);
  app.failure_message(voltlap::plant::usage_message);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? voltlap::plant::kExitOk : voltlap::plant::kExitInput;
  }
  std::optional<Measurement> earlier;
  if (!flags.compare.empty()) earlier = read_json(flags.compare);
  check_writable(flags.json);
  check_writable(flags.markdown);

  const Measurement now = measure(flags.plan);
  std::FILE* out = voltlap::plant::summary_stream({flags.json, flags.markdown});
  print_rows(out, now);
  write(flags.json, to_json(now));
  write(flags.markdown, to_markdown(now));
  if (!earlier) return voltlap::plant::kExitOk;
  const auto rows = compare(*earlier, now);
  fmt::print(out, "\n{}", comparison_text(*earlier, now, rows));
  return any_slower(rows) ? kExitSlower : voltlap::plant::kExitOk;
}

}  // namespace

int main(int argc, char** argv) { return voltlap::plant::guarded_main(run, argc, argv); }
