// SPDX-License-Identifier: Apache-2.0
#include "replay/replay_baseline.hpp"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/errors.hpp"
#include "core/input_files.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

Json read_baseline(const std::string& path) {
  note_input(path);
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  Json out = Json::parse(text.str(), nullptr, false);
  if (!file || out.is_discarded() || !out.is_object() || !out.contains("frames_by_verdict")) {
    throw InputError("--baseline " + path, file ? "no result of a replay" : "no file that can be read",
                     "what voltlap replay --json wrote", "Make it first: voltlap replay LOG --json " + path);
  }
  return out;
}

Json flat(Json result) {
  for (const char* key : {"voltlap", "log", "map", "pack"}) result.erase(key);
  return result.flatten();
}

std::string name_of(const std::string& pointer) { return pointer.empty() ? pointer : pointer.substr(1); }

}  // namespace

std::vector<std::string> changes_since(const std::string& baseline_path, const std::string& now_json) {
  const Json before = flat(read_baseline(baseline_path)), now = flat(Json::parse(now_json));
  std::vector<std::string> out;
  for (const auto& [key, value] : now.items()) {
    const auto was = before.find(key);
    if (was == before.end()) {
      out.push_back(fmt::format("{}: new, {}", name_of(key), value.dump()));
    } else if (*was != value) {
      out.push_back(fmt::format("{}: {} -> {}", name_of(key), was->dump(), value.dump()));
    }
  }
  for (const auto& [key, value] : before.items()) {
    if (!now.contains(key)) out.push_back(fmt::format("{}: gone, {}", name_of(key), value.dump()));
  }
  return out;
}

}  // namespace voltlap::plant
