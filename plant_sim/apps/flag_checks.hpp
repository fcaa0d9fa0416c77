// SPDX-License-Identifier: Apache-2.0
// What the value of a flag may be. Each check refuses with what was found, what was expected and what to do.
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

namespace voltlap::plant {

/// One of some words; the nearest one is suggested.
[[nodiscard]] CLI::Validator one_of(std::vector<std::string> words);
/// A whole number, both ends included.
[[nodiscard]] CLI::Validator whole_number(unsigned long long low, unsigned long long high);
/// A number above 0.
[[nodiscard]] CLI::Validator positive_number();
/// Any number, both ends included.
[[nodiscard]] CLI::Validator number_between(double low, double high,
                                            std::string what_to_do = "Correct the number, or leave the flag out");
/// A finite number of 0 or more.
[[nodiscard]] CLI::Validator number_from_zero();

/// A name that is not empty; `expected` in words.
[[nodiscard]] CLI::Validator some_name(std::string expected);

/// Adds a flag that names a result file; `-` is standard output.
CLI::Option* add_output_file(CLI::App& command, const std::string& flag, std::string& file, const std::string& help);

/// Two flags that name the same file are refused.
void refuse_shared_files(const std::vector<std::pair<std::string, std::string>>& file_of_flag);

/// Where the summary for people goes: to standard error when a result file takes standard output.
[[nodiscard]] std::FILE* summary_stream(std::initializer_list<std::string> result_files);

/// The message for a command line that cannot be parsed, with the nearest command or flag.
[[nodiscard]] std::string usage_message(const CLI::App* app, const CLI::Error& error);

}  // namespace voltlap::plant
