// SPDX-License-Identifier: Apache-2.0
// same_firmware OLD.so PRESENT.so CALLS SEED: drawn runs of both versions until CALLS calls of a node are made. Prints
// one JSON object: what was reached, or the difference with a short input that shows it. Exit code: 0 equal, 1 not.
#include <cstdio>
#include <cstdlib>

#include "run.hpp"
#include "settings.hpp"
#include "shrink.hpp"

namespace same_firmware {
namespace {

template <class Counts>
void print_counts(const char* name, const Counts& counts) {
  std::printf(", \"%s\": [", name);
  const char* separator = "";
  for (const std::uint64_t count : counts) {
    std::printf("%s%llu", separator, static_cast<unsigned long long>(count));
    separator = ", ";
  }
  std::printf("]");
}

void print(const Reached& r) {
  std::printf("{\"calls\": %llu, \"runs\": %llu, \"torque_ticks\": %llu, \"failures\": %llu",
              static_cast<unsigned long long>(r.calls), static_cast<unsigned long long>(r.runs),
              static_cast<unsigned long long>(r.torque_ticks), static_cast<unsigned long long>(r.failures));
  print_counts("drive_states", r.drive_states);
  print_counts("bms_states", r.bms_states);
  print_counts("master_faults", r.master_faults);
  print_counts("bms_faults", r.bms_faults);
  std::printf("}\n");
}

void print(std::span<const WireFrame> frames) {
  const char* separator = "";
  std::printf("[");
  for (const WireFrame& frame : frames) {
    std::printf("%s[%u, \"", separator, frame.id);
    for (std::size_t i = 0; i < frame.dlc; ++i) std::printf("%02X", frame.data[i]);
    std::printf("\"]");
    separator = ", ";
  }
  std::printf("]");
}

void print(const Outcome& outcome) {
  std::printf("{\"failure\": \"");
  for (const char* c = outcome.failure == nullptr ? "" : outcome.failure; *c != '\0'; ++c) {
    std::printf(*c == '"' || *c == '\\' ? "\\%c" : "%c", *c);
  }
  std::printf("\", \"frames\": ");
  print(outcome.frames());
  std::printf("}");
}

void print_changed(Settings settings) {
  Settings by_itself;
  const auto drawn = settings_by_name(settings), own = settings_by_name(by_itself);
  const char* separator = "";
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    if (*drawn[i].value == *own[i].value) continue;
    std::printf("%s\"%s\": %d", separator, drawn[i].name, *drawn[i].value);
    separator = ", ";
  }
}

/// The answers of both versions to every step, beside the step.
void print(const Versions& versions, const Difference& d, std::size_t steps_before) {
  std::printf("{\"node\": \"%s\", \"run\": %llu, \"tick\": %u, \"steps_before\": %zu, \"settings\": {",
              d.which == Which::kBms ? "BMS" : "master", static_cast<unsigned long long>(d.seed), d.tick, steps_before);
  print_changed(d.settings);
  std::printf("}, \"steps\": [");
  Pair pair(versions, d.which, d.settings);
  for (std::size_t i = 0; i < d.steps.size(); ++i) {
    if (d.steps[i].restart) pair.restart();
    static_cast<void>(pair.tick(d.steps[i].now_ms, d.steps[i].rx));
    std::printf("%s\n{\"now_ms\": %u, \"restart\": %s, \"rx\": ", i == 0 ? "" : ",", d.steps[i].now_ms,
                d.steps[i].restart ? "true" : "false");
    print(d.steps[i].rx);
    std::printf(", \"old\": ");
    print(pair.of_old());
    std::printf(", \"present\": ");
    print(pair.of_present());
    std::printf("}");
  }
  std::printf("]}\n");
}

int compare(const Versions& versions, std::uint64_t calls, std::uint64_t seed) {
  Reached reached;
  for (std::uint64_t i = 0; reached.calls < calls; ++i) {
    const std::uint64_t seed_of_run = (seed << 32) + i;
    if (auto difference = run(versions, seed_of_run, calls, reached)) {
      const std::size_t steps = difference->steps.size();
      print(versions, shrink(versions, std::move(*difference)), steps);
      return 1;
    }
  }
  print(reached);
  return 0;
}

}  // namespace
}  // namespace same_firmware

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: same_firmware OLD.so PRESENT.so CALLS SEED\n");
    return 2;
  }
  const same_firmware::Versions versions = same_firmware::load_versions(argv[1], argv[2]);
  return same_firmware::compare(versions, std::strtoull(argv[3], nullptr, 10), std::strtoull(argv[4], nullptr, 10));
}
