// SPDX-License-Identifier: Apache-2.0
#include "apps/explain_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/progress_line.hpp"
#include "core/errors.hpp"
#include "core/toml_text.hpp"
#include "discrepancy/explanation_json.hpp"
#include "discrepancy/extended_model.hpp"
#include "report/atomic_file.hpp"

namespace voltlap::plant {
namespace {

std::string text_of(const FoundParameter& p) {
  if (p.unit == "name") return fmt::format("{} {}", p.name, p.text);
  if (p.unit == "index") return fmt::format("{} {:.0f}", p.name, p.value);
  return fmt::format("{} {:.4g} ({:.4g} to {:.4g}) {}", p.name, p.value, p.low, p.high, p.unit);
}

void print(std::FILE* to, const Explanation& e) {
  fmt::print(to, "{}: {}\n", name_of(e.verdict), e.sentence);
  for (const FoundCause& cause : e.causes) {
    fmt::print(to, "\n{}: probability {:.2f}, d' {:.1f}, {:.0f} % of the error\n", cause.name, cause.probability,
               cause.d_prime, 100.0 * cause.share_of_residual);
    for (const FoundParameter& p : cause.parameters) fmt::print(to, "  {}\n", text_of(p));
    if (!cause.equivalent_to.empty()) {
      fmt::print(to, "  this log cannot tell it from {}\n", fmt::join(cause.equivalent_to, ", "));
    }
  }
  if (!e.gain.empty()) fmt::print(to, "\nRMS error on blocks that were kept back\n");
  for (const auto& [channel, gain] : e.gain) {
    fmt::print(to, "  {:<18} {:9.4g} to {:9.4g} {} (noise {:.3g})\n", channel, gain.before, gain.after, gain.unit,
               gain.floor);
  }
  for (const RunnerUp& rival : e.runners_up) {
    fmt::print(to, "  runner-up {}: {:.1f} behind in ln evidence, {}\n", fmt::join(rival.names, " + "), rival.behind,
               rival.why);
  }
  if (!e.next_test.empty()) fmt::print(to, "\nThe test that would tell: {}.\n", e.next_test);
  for (const std::string& note : e.notes) fmt::print(to, "  {}\n", note);
  constexpr std::size_t kShown = 10;
  for (std::size_t k = 0; k < e.masked.size() && k < kShown; ++k) {
    const Masked& m = e.masked[k];
    fmt::print(to, "  not used: {} from {:.1f} to {:.1f} s, {}\n", m.channel, m.start_s, m.end_s, m.reason);
  }
  if (e.masked.size() > kShown) fmt::print(to, "  and {} stretches more\n", e.masked.size() - kShown);
}

}  // namespace

ExplainCommand::ExplainCommand(CLI::App& app)
    : command_(app.add_subcommand("explain", "What a simulation gets wrong about a log: the cause, its size, the gain")) {
  command_->add_option("log", log_, "Table of a cell test, a pack or a car; CSV, also gzipped")->required();
  command_->add_option("--map", map_, "Role map: name or path; default: by column names, or a shipped map by its header");
  command_->add_option("--model", model_, "Cell, pack or vehicle file (TOML): name or path")->required();
  command_->add_option("--reference", references_, "Logs that are known to be good: what is usual is learned from them");
  add_output_file(*command_, "--json", json_, "Write the explanation as JSON");
  add_output_file(*command_, "--write-model", write_model_, "Write the model with its causes, of the kind that was given");
  command_->add_option("--set", settings_, "key=value of the model, or explain.without=CAUSE, explain.fit_blocks=even|odd")
      ->allow_extra_args(false);
  command_->add_option("--seed", seed_, "Seed of the null distribution")->capture_default_str();
  command_->footer("Example: voltlap explain drive.csv --model vtm16e --reference good1.csv --reference good2.csv");
}

std::vector<std::string> ExplainCommand::take_settings(ExplainOptions& options) const {
  std::vector<std::string> model;
  for (const std::string& text : settings_) {
    if (!text.starts_with("explain.")) {
      model.push_back(text);
      continue;
    }
    const Setting setting = parse_setting(text);
    const auto word = setting.value->value<std::string>();
    if (setting.key == "explain.without" && word) {
      options.without.push_back(*word);
    } else if (setting.key == "explain.fit_blocks" && word && (*word == "even" || *word == "odd" || *word == "all")) {
      options.fit_blocks = *word;
    } else {
      throw InputError("--set " + text, "an unknown setting", "explain.without=CAUSE or explain.fit_blocks=even|odd|all",
                       "Correct it");
    }
  }
  return model;
}

int ExplainCommand::run(const DataFolder& data) {
  std::optional<AtomicFile> json, extended;
  if (!json_.empty()) json.emplace(json_);
  ExplainOptions options;
  options.seed = seed_;
  Model model = load_model(data, model_, take_settings(options));
  const Recording log = read_recording(data, log_, map_);
  fit_to_log(model, log);
  for (const std::string& path : references_) options.references.push_back(read_recording(data, path, map_));
  ProgressLine line("explain");
  options.progress = [&](const std::string& what, double fraction) { line.show(what, fraction); };
  const Explanation explanation = explain(model, log, options);
  line.end();
  std::string written;
  if (!write_model_.empty() && explanation.world) {
    const std::string text = extended_model_toml(model, *explanation.world, explanation.sentence);
    if (!text.empty()) {
      extended.emplace(write_model_);
      extended->write(text);
      extended->commit();
      written = write_model_;
    }
  }
  std::FILE* to = summary_stream({json_, write_model_});
  print(to, explanation);
  if (!write_model_.empty() && written.empty()) {
    fmt::print(to, "No extended model: {}\n", explanation.world ? "the cause is in a sensor, not in the car"
                                                                : "no cause was found");
  }
  if (json) {
    json->write(explanation_json(explanation, seed_, VOLTLAP_VERSION, written));
    json->commit();
  }
  return kExitOk;
}

}  // namespace voltlap::plant
