// SPDX-License-Identifier: Apache-2.0
#include "core/toml_text.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>

#include "core/errors.hpp"
#include "core/input_files.hpp"

namespace voltlap::plant {

std::string shown_path(const std::string& path) {
  std::error_code ignored;
  const std::string near = std::filesystem::proximate(path, ignored).string();
  return near.empty() || near.size() > path.size() ? path : near;
}

toml::table parse_toml_file(const std::string& path) {
  note_input(path);
  try {
    return toml::parse_file(path);
  } catch (const toml::parse_error& error) {
    const auto line = error.source().begin.line;
    throw InputError(line != 0 ? fmt::format("{}:{}", shown_path(path), line) : shown_path(path),
                     fmt::format("no valid TOML ({})", error.description()),
                     "lines of the form key = value under [section] headings, each key once", "Correct this line");
  }
}

std::string found_text(const toml::node& node) {
  if (node.is_floating_point()) return fmt::format("{}", **node.as_floating_point());  // as short as it was written
  std::ostringstream out;
  node.visit([&](const auto& value) { out << value; });
  std::string text = out.str();
  constexpr std::size_t kShown = 60;
  return text.size() > kShown ? text.substr(0, kShown) + " ..." : text;
}

std::optional<double> number_of(const toml::node& node) {
  if (!node.is_number()) return std::nullopt;
  return node.value<double>();
}

std::shared_ptr<toml::node> copy_of(const toml::node& node) {
  std::shared_ptr<toml::node> copy;
  node.visit([&](const auto& value) { copy = std::make_shared<std::decay_t<decltype(value)>>(value); });
  return copy;
}

std::string take_word(toml::table& table, const std::string& name, const std::string& file) {
  const toml::node* node = table.get(name);
  if (node == nullptr) return {};
  const auto word = node->value<std::string>();
  if (!word) {
    throw InputError(fmt::format("{}:{}, {}", file, node->source().begin.line, name), found_text(*node),
                     "a word in quotes", "Put it in quotes");
  }
  table.erase(name);
  return *word;
}

Setting parse_setting(const std::string& setting) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == setting.size()) {
    throw InputError("--set " + setting, "no key=value", "for instance --set vehicle.mass_kg=219",
                     "Write the key, an equals sign and the value, without spaces");
  }
  const std::string text = setting.substr(equals + 1);
  try {
    return {setting.substr(0, equals), copy_of(*toml::parse("value = " + text).get("value"))};
  } catch (const toml::parse_error&) {
    return {setting.substr(0, equals), std::make_shared<toml::value<std::string>>(text)};
  }
}

}  // namespace voltlap::plant
