// SPDX-License-Identifier: Apache-2.0
#include "apps/replay_season.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <system_error>

#include "apps/exit_code.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"
#include "replay/replay_baseline.hpp"
#include "replay/replay_text.hpp"

namespace voltlap::plant {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kShown = 12;  // changes of one log

/// What stands beside logs and is none.
bool is_no_log(const fs::path& path) {
  static const std::set<std::string> kOthers = {".json", ".html", ".toml", ".md",    ".dbc", ".png",
                                                ".pdf",  ".svg",  ".py",   ".o2bms", ".sh",  ".ipynb"};
  return kOthers.count(path.extension().string()) > 0;
}

/// Files below a folder by their paths from it, in the order of their names. A link to a folder is not followed: it
/// may lead back.
std::vector<std::string> files_below(const std::string& folder, const std::function<bool(const fs::path&)>& left_out) {
  std::vector<std::string> out;
  std::error_code error, of_one;
  fs::recursive_directory_iterator at(folder, error);
  for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    const bool hidden = at->path().filename().string().front() == '.';
    if (hidden && at->is_directory(of_one)) at.disable_recursion_pending();
    if (hidden || !at->is_regular_file(of_one) || left_out(at->path())) continue;
    out.push_back(at->path().lexically_relative(folder).string());
  }
  if (error) throw InputError(folder, error.message(), "a folder that can be read", "Look at its permissions");
  std::sort(out.begin(), out.end());
  return out;
}

void write_json(const fs::path& path, const ReplayResult& result) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);  // the file itself says what is wrong
  AtomicFile file(path.string());
  file.write(replay_json(result, VOLTLAP_VERSION));
  file.commit();
}

std::string percent(double share) { return std::isfinite(share) ? fmt::format("{:.1f}", 100.0 * share) : "-"; }

std::string line_of(const ReplayResult& r) {
  const auto opens = std::count_if(r.faults.begin(), r.faults.end(), [](const ReplayFault& f) { return f.opens; });
  std::string out = fmt::format("{:.0f} s, SOC {} to {} %, logged {} to {} %; {} disagreements", r.duration_s,
                                percent(r.soc_start()), percent(r.soc_end()), percent(r.logged_soc_start()),
                                percent(r.logged_soc_end()), r.disagreements.size());
  if (!r.never_ready.empty()) return out + ", never ready: " + r.never_ready;
  if (opens > 0) out += fmt::format(", {} trips, first {}", opens,
                                    std::find_if(r.faults.begin(), r.faults.end(),
                                                 [](const ReplayFault& f) { return f.opens; })->id);
  return out;
}

class Run {
 public:
  Run(const Season& season, std::FILE* to) : season_(season), to_(to) {}

  int all() {
    if (has_baseline() && !fs::is_directory(season_.baseline_folder)) {
      throw InputError("--baseline " + season_.baseline_folder, "no folder", "the folder that --json was once",
                       "Make it first: voltlap replay FOLDER --json " + season_.baseline_folder);
    }
    const std::vector<std::string> logs = files_below(season_.folder, is_no_log);
    if (logs.empty()) {
      throw InputError(season_.folder, "no log", "CAN recordings or tables, plain or compressed",
                       "Name the folder that they are in");
    }
    for (const std::string& log : logs) one(log);
    note_gone(logs);
    fmt::print(to_, "\n{} logs: {} replayed, {} refused", logs.size(), replayed_, logs.size() - replayed_);
    if (has_baseline()) fmt::print(to_, "; {} changed, {} new, {} gone since {}", changed_, new_, gone_,
                                   season_.baseline_folder);
    fmt::print(to_, "\n");
    if (replayed_ == 0) return kExitInput;
    return changed_ + gone_ > 0 ? kExitDefects : kExitOk;
  }

 private:
  [[nodiscard]] bool has_baseline() const { return !season_.baseline_folder.empty(); }
  [[nodiscard]] fs::path baseline_of(const std::string& log) const {
    return fs::path(season_.baseline_folder) / (log + ".json");
  }

  void one(const std::string& log) {
    std::optional<ReplayResult> result;
    try {
      result = season_.replay((fs::path(season_.folder) / log).string());
      fmt::print(to_, "{}: {}\n", log, line_of(*result));
      ++replayed_;
    } catch (const InputError& refusal) {
      fmt::print(to_, "{}: refused: {}\n", log, refusal.what());
      const fs::path earlier = fs::path(season_.json_folder) / (log + ".json");
      if (!season_.json_folder.empty() && fs::exists(earlier)) {
        fmt::print(to_, "  {} is the result of an earlier run\n", earlier.string());
      }
    }
    if (result && !season_.json_folder.empty()) write_json(fs::path(season_.json_folder) / (log + ".json"), *result);
    if (has_baseline()) compare(log, result);
  }

  void compare(const std::string& log, const std::optional<ReplayResult>& result) {
    const bool known = fs::exists(baseline_of(log));
    if (!known && result) {
      ++new_;
      fmt::print(to_, "  new: the baseline has no {}.json\n", log);
    }
    if (!known) return;
    if (!result) {
      ++changed_;
      fmt::print(to_, "  it was replayed before\n");
      return;
    }
    const std::vector<std::string> changes =
        changes_since(baseline_of(log).string(), replay_json(*result, VOLTLAP_VERSION));
    if (!changes.empty()) ++changed_;
    for (std::size_t k = 0; k < changes.size() && k < kShown; ++k) fmt::print(to_, "  {}\n", changes[k]);
    if (changes.size() > kShown) fmt::print(to_, "  and {} more\n", changes.size() - kShown);
  }

  void note_gone(const std::vector<std::string>& logs) {
    if (!has_baseline()) return;
    const auto other = [](const fs::path& path) { return path.extension() != ".json"; };
    for (const std::string& file : files_below(season_.baseline_folder, other)) {
      const std::string log = file.substr(0, file.size() - std::string(".json").size());
      if (std::binary_search(logs.begin(), logs.end(), log)) continue;
      ++gone_;
      fmt::print(to_, "{}: gone, the baseline has it\n", log);
    }
  }

  const Season& season_;
  std::FILE* to_;
  std::size_t replayed_ = 0, changed_ = 0, new_ = 0, gone_ = 0;
};

}  // namespace

int replay_season(const Season& season, std::FILE* to) { return Run(season, to).all(); }

}  // namespace voltlap::plant
