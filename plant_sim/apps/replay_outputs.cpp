// SPDX-License-Identifier: Apache-2.0
#include "apps/replay_outputs.hpp"

#include "apps/flag_checks.hpp"
#include "io/atomic_file.hpp"
#include "replay/replay_report.hpp"
#include "replay/replay_text.hpp"

namespace voltlap::plant {

void ReplayOutputs::add(CLI::App& command) {
  add_output_file(command, "--json", json, "Write the result as JSON; -: to standard output");
  add_output_file(command, "--csv", csv, "Write a time series, ten rows a second");
  add_output_file(command, "--report", report, "Write a report as one HTML file");
}

void ReplayOutputs::write(const ReplayResult& result) const {
  const auto write = [](const std::string& path, const auto& text) {
    if (path.empty()) return;
    AtomicFile file(path);
    file.write(text());
    file.commit();
  };
  write(json, [&] { return replay_json(result, VOLTLAP_VERSION); });
  write(csv, [&] { return replay_csv(result); });
  write(report, [&] { return replay_report(result, VOLTLAP_VERSION); });
}

std::FILE* ReplayOutputs::stream() const { return summary_stream({json, csv, report}); }

}  // namespace voltlap::plant
