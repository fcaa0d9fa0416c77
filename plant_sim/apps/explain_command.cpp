// SPDX-License-Identifier: Apache-2.0
#include "apps/explain_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>

#include "apps/exit_code.hpp"
#include "apps/firmware_loop.hpp"
#include "apps/flag_checks.hpp"
#include "apps/other_programs.hpp"
#include "apps/run_recorder.hpp"
#include "core/errors.hpp"
#include "core/toml_text.hpp"
#include "explain/explain.hpp"
#include "explain/extend/extended_model.hpp"
#include "explain/say/explanation_json.hpp"
#include "explain/say/numbers.hpp"
#include "explain/say/page/explanation_report.hpp"
#include "io/atomic_file.hpp"

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
    const ShownUnit shown = shown_unit(gain.unit, gain.before);
    fmt::print(to, "  {:<18} {:9.4g} to {:9.4g} {} (noise {:.3g})\n", channel, shown.scale * gain.before,
               shown.scale * gain.after, shown.unit, shown.scale * gain.floor);
  }
  for (const RunnerUp& rival : e.runners_up) {
    fmt::print(to, "  not {}: {:.1f} {} in ln evidence{} {}\n", fmt::join(rival.names, " + "), std::abs(rival.behind),
               rival.behind < 0.0 ? "ahead" : "behind", rival.behind < 0.0 ? ", but" : ",", rival.why);
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

/// Ctrl-C between two steps of the explanation.
struct Interrupted {};

/// One explanation's files: nothing is put in place before all are whole.
class Outputs {
 public:
  explicit Outputs(std::initializer_list<std::string> paths) {
    for (const std::string& path : paths)
      files_.push_back(path.empty() ? nullptr : std::make_unique<AtomicFile>(path));
  }
  [[nodiscard]] AtomicFile* operator[](std::size_t k) { return files_[k].get(); }
  void leave_out(std::size_t k) { files_[k].reset(); }
  void commit() {
    for (const auto& file : files_) {
      if (file) file->complete();
    }
    for (const auto& file : files_) {
      if (file) file->commit();
    }
  }

 private:
  std::vector<std::unique_ptr<AtomicFile>> files_;
};

/// Why no extended model was written.
std::string no_model_because(const Explanation& e, const Model& model) {
  if (!e.world) return "no cause was found that a model could contain";
  const auto left_out = extended_car(model.world, *e.world).left_out;
  if (!left_out.empty()) return fmt::format("a car file has no parameter for {}", fmt::join(left_out, ", "));
  if (model.kind != ModelKind::kCell) return "the cause is in a sensor, not in the car";
  return "it is not in the cell of this file but in a sensor, a contact or one cell of many; a pack file as "
         "--model "
         "can hold the last two";
}

}  // namespace

ExplainCommand::ExplainCommand(CLI::App& app) : command_(app.add_subcommand("explain", what_it_does("explain"))) {
  command_->add_option("log", log_, "Log of a cell test, a pack or a car: CSV, also gzipped, or CAN through a map")
      ->required();
  command_->add_option("--map", map_,
                       "Role map: name or path; default: by column names, or a shipped map by its header");
  finding_.add(*command_);
  command_->add_option("--model", model_, "Cell, pack or vehicle file (TOML): name or path")->required();
  command_->add_option("--reference", references_,
                       "Logs that are known to be good: what is usual is learned from them");
  command_->add_option("--holdout", holdout_,
                       "A second log, on which the gain is measured instead of on blocks of the first");
  add_output_file(*command_, "--json", json_, "Write the explanation as JSON");
  add_output_file(*command_, "--report", report_,
                  "Write a report as one HTML file, with the endurance before and after: a few seconds more");
  add_output_file(*command_, "--write-model", write_model_,
                  "Write the model with its causes, of the kind that was given");
  command_
      ->add_option("--set", settings_,
                   "Change the model (voltlap list keys), or explain.without=CAUSE, explain.fit_blocks=even|odd; "
                   "key=value, one or several")
      ->type_name("KEY=VALUE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command_
      ->add_option("--seed", seed_,
                   "Written into the JSON; the answer itself draws nothing, every seed gives the same")
      ->check(whole_number(0, std::numeric_limits<decltype(seed_)>::max()))
      ->capture_default_str();
  command_->footer(
      "With --report the endurance is driven as the model was given and as it was extended (not without it: an\n"
      "explanation takes seconds, a race as well); --json then has it as `prediction`. See docs/explain.md.\n"
      "Example: voltlap explain drive.csv --model vtm16e --reference good1.csv --reference good2.csv --report "
      "why.html\n"
      "Exit code: 0 a verdict was reached, whichever; 2 usage or input; 130 interrupted.");
}

std::unique_ptr<ScratchFile> ExplainCommand::find_map() {
  finding_.check_needed(!map_.empty());
  if (!finding_.is_asked()) return nullptr;
  const std::optional<RoleMap> map = finding_.find(log_);
  for (const std::string& note : map->notes) fmt::print(stderr, "{}\n", note);
  if (!finding_.write_map.empty() && finding_.write_map != AtomicFile::kStandardOutput) {
    map_ = finding_.write_map;
    return nullptr;
  }
  auto file = std::make_unique<ScratchFile>(finding_.text(log_));
  map_ = file->path();
  return file;
}

void ExplainCommand::refuse_shared_files() const {
  const auto same = [](const std::string& a, const std::string& b) {
    std::error_code ignored;
    return a == b || std::filesystem::equivalent(a, b, ignored);
  };
  const std::pair<const char*, std::string> outputs[] = {{"--json", json_},
                                                         {"--report", report_},
                                                         {"--write-model", write_model_},
                                                         {"--write-map", finding_.write_map}};
  std::vector<std::pair<const char*, std::string>> inputs = {
      {"the log", log_}, {"--model", model_}, {"--map", map_}, {"--holdout", holdout_}};
  for (const std::string& reference : references_) inputs.emplace_back("--reference", reference);
  for (const auto& [flag, file] : outputs) {
    if (file.empty()) continue;
    for (const auto& [other, output] : outputs) {
      if (std::string_view(flag) != other && !output.empty() && same(file, output)) {
        throw InputError(fmt::format("{}, {}", flag, other), "one file for both", "a file for each",
                         "Give different names");
      }
    }
    for (const auto& [input, path] : inputs) {
      if (path.empty() || !same(file, path)) continue;
      throw InputError(fmt::format("{} {}", flag, file), fmt::format("the file that {} names", input),
                       "an output that is no input", "Give another name; the input was left as it is");
    }
  }
}

std::vector<std::string> ExplainCommand::take_settings(explain::ExplainOptions& options) {
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
    } else if (setting.key == "explain.fit_blocks" && word &&
               (*word == "even" || *word == "odd" || *word == "all")) {
      options.fit_blocks = *word;
    } else {
      throw InputError("--set " + text, "an unknown setting",
                       "explain.without=CAUSE or explain.fit_blocks=even|odd|all", "Correct it");
    }
  }
  return model;
}

Explanation ExplainCommand::explained(const DataFolder& data, Model& model,
                                      const explain::ExplainOptions& asked) const {
  explain::ExplainOptions options = asked;
  const auto step = [&](const std::string& what, double fraction) {
    if (interrupted()) throw Interrupted{};
    options.progress(what, fraction);
  };
  step("reading " + log_, 0.0);
  Recording log = read_recording(data, log_, map_);
  fit_to_log(model, log);
  const auto other = [&](const std::string& path) {
    Recording out = read_recording(data, path, map_);
    Model same = model;
    fit_to_log(same, out);  // of the same pack
    return out;
  };
  for (const std::string& path : references_) {
    step("reading " + path, 0.05);
    options.references.push_back(other(path));
  }
  if (!holdout_.empty()) options.holdout = other(holdout_);
  step("comparing", 0.1);
  options.progress = [&](const std::string& what, double fraction) {
    if (interrupted()) throw Interrupted{};
    asked.progress(what, fraction);
  };
  return explain::explain(model, std::move(log), std::move(options));
}

std::optional<RaceChange> ExplainCommand::raced(const DataFolder& data, const Model& model,
                                                const Explanation& explanation, ProgressLine& line) const {
  if (report_.empty() || !explanation.world) return std::nullopt;
  RaceTools tools;
  tools.firmware = [](const VehicleParameters& car) { return std::make_unique<FirmwareLoop>(car); };
  tools.progress = [&](const std::string& what, double fraction) { line.show(what, fraction); };
  tools.stop_requested = interrupted;
  std::optional<RaceChange> out = race_change(data, model, *explanation.world, tools);
  if (out->stopped) throw Interrupted{};
  return out;
}

std::vector<std::pair<std::string, std::string>> ExplainCommand::run_facts(const Model& model) const {
  const char* kinds[] = {"cell", "pack", "vehicle"};
  std::vector<std::pair<std::string, std::string>> out = {
      {"log", log_},
      {"model", fmt::format("{} ({} file)", model_, kinds[static_cast<std::size_t>(model.kind)])},
      {"--reference", references_.empty() ? "none" : fmt::format("{}", fmt::join(references_, ", "))}};
  if (!map_.empty()) out.emplace_back("--map", finding_.is_asked() ? "made from the log" : map_);
  if (!holdout_.empty()) out.emplace_back("--holdout", holdout_);
  out.emplace_back("--set", settings_.empty() ? "nothing" : fmt::format("{}", fmt::join(settings_, " ")));
  out.emplace_back("seed", fmt::format("{}", seed_));
  return out;
}

int ExplainCommand::run(const DataFolder& data) try {
  refuse_shared_files();
  explain::ExplainOptions options;
  Model model = load_model(data, model_, take_settings(options));
  const auto map_file = find_map();
  catch_interrupt();  // before there is a file that must not stay behind
  Outputs files{json_, report_, write_model_};
  ProgressLine line("explain");
  options.progress = [&](const std::string& what, double fraction) { line.show(what, fraction); };
  const Explanation explanation = explained(data, model, options);
  const std::optional<RaceChange> race = raced(data, model, explanation, line);
  line.end();
  std::string extended;
  if (files[2] != nullptr && explanation.world) {
    const ExtendedCar car = extended_car(model.world, *explanation.world);
    extended = extended_model_toml(model, car.car, explanation.sentence);
  }
  if (extended.empty()) files.leave_out(2);
  const RaceChange* driven = race ? &*race : nullptr;
  if (files[0] != nullptr) {
    const std::string written = extended.empty() ? "" : write_model_;
    files[0]->write(explanation_json(explanation, driven, seed_, VOLTLAP_VERSION, written));
  }
  if (files[1] != nullptr) {
    files[1]->write(explanation_report({explanation, driven, run_facts(model), VOLTLAP_VERSION}));
  }
  if (!extended.empty()) files[2]->write(extended);
  files.commit();
  std::FILE* to = summary_stream({json_, report_, write_model_});
  print(to, explanation);
  if (!write_model_.empty() && extended.empty()) {
    fmt::print(to, "No extended model: {}\n", no_model_because(explanation, model));
  }
  return kExitOk;
} catch (const Interrupted&) {
  fmt::print(stderr, "Interrupted; no result file was written.\n");
  return exit_code_of_interrupt();
}

}  // namespace voltlap::plant
