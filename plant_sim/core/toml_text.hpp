// SPDX-License-Identifier: Apache-2.0
// What every reader of TOML files and `--set key=value` needs, with errors that a person can mend.
#pragma once
#include <toml++/toml.h>

#include <memory>
#include <optional>
#include <string>

namespace voltlap::plant {

/// The path as a person at the prompt would write it.
[[nodiscard]] std::string shown_path(const std::string& path);

/// Throws InputError with file and line for bad TOML.
[[nodiscard]] toml::table parse_toml_file(const std::string& path);

/// A value as it stands in the file, cut short for a message.
[[nodiscard]] std::string found_text(const toml::node& node);

[[nodiscard]] std::optional<double> number_of(const toml::node& node);

/// A node that outlives its table.
[[nodiscard]] std::shared_ptr<toml::node> copy_of(const toml::node& node);

/// Takes a word that is no key of a parameter table (`name`, `base`) out of a file's table; empty when it is not
/// there.
[[nodiscard]] std::string take_word(toml::table& table, const std::string& name, const std::string& file);

struct Setting {
  std::string key;
  std::shared_ptr<toml::node> value;
};

/// `key=value`; what is not a TOML value is taken as a word, so that battery.cell=leaf needs no quotes.
[[nodiscard]] Setting parse_setting(const std::string& setting);

}  // namespace voltlap::plant
