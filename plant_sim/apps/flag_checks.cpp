// SPDX-License-Identifier: Apache-2.0
#include "apps/flag_checks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <system_error>

#include "core/errors.hpp"
#include "core/parameter_table.hpp"
#include "io/atomic_file.hpp"

namespace voltlap::plant {
namespace {

std::string refusal(const std::string& found, const std::string& expected, const std::string& what_to_do) {
  return fmt::format("found {}; expected {}. {}.", found, expected, what_to_do);
}

template <class Number>
std::optional<Number> parsed(const std::string& text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  const std::string nearest = nearest_of(word, known, std::max<std::size_t>(1, word.size() / 3));
  return nearest.empty() ? "" : fmt::format(" Did you mean {}?", nearest);
}

/// The command that was parsed, the innermost where they nest, else the whole program.
const CLI::App& active(const CLI::App& app) {
  const auto commands = app.get_subcommands();
  return commands.empty() ? app : active(*commands.front());
}

/// "voltlap", "voltlap lap", "voltlap track import".
std::string words_to(const CLI::App& command) {
  const CLI::App* outer = command.get_parent();
  return outer == nullptr ? "voltlap" : words_to(*outer) + ' ' + command.get_name();
}

/// The same without the program.
std::string title_of(const CLI::App& command) {
  const std::string words = words_to(command);
  return words.substr(std::min(words.size(), words.find(' ') + 1));
}

/// For a command that asks for one of its own: none was given, or one that it does not have.
std::string unknown_command(const CLI::App& command, const std::string& where, const std::string& help) {
  std::vector<std::string> known;
  for (const CLI::App* inner : command.get_subcommands(nullptr)) known.push_back(inner->get_name());
  const auto words = command.remaining();
  const std::string found = words.empty() ? "no command" : fmt::format("\"{}\", which is no command", words.front());
  return fmt::format("{}: found {}; expected one of {}.{} See {}.", where, found, fmt::join(known, ", "),
                     words.empty() ? "" : did_you_mean(words.front(), known), help);
}

std::string unknown_argument(const CLI::App& command, const std::string& help) {
  const auto words = command.remaining();
  const auto flag =
      std::find_if(words.begin(), words.end(), [](const std::string& word) { return word.starts_with("-"); });
  if (flag == words.end()) {
    return fmt::format(
        "{}: found \"{}\", which belongs to no flag; expected flags and their values. Leave it out, or see {}.",
        title_of(command), words.empty() ? "" : words.front(), help);
  }
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  const std::string name = flag->substr(0, flag->find('='));
  return fmt::format("{}: found the unknown flag {}; expected a flag that {} shows.{} Correct the flag.",
                     title_of(command), name, help, did_you_mean(name, known));
}

/// "--vehicle: 1 required TEXT missing", "what is required".
std::string missing_value(const std::string& said, const std::string& help) {
  const std::string name = said.substr(0, said.find_first_of(": "));
  return fmt::format("{}: found no value; expected one behind it. Add it; {} shows what it may be.", name, help);
}

/// "A excludes B", "A requires B": the two names.
std::pair<std::string, std::string> two_names(const std::string& text, const std::string& between) {
  const std::size_t at = text.find(between);
  if (at == std::string::npos) return {text, "the other"};
  return {text.substr(0, at), text.substr(at + between.size())};
}

}  // namespace

CLI::Validator one_of(std::vector<std::string> words) {
  const std::string shown = fmt::format("{}", fmt::join(words, "|"));
  return {[words](const std::string& word) {
            if (std::find(words.begin(), words.end(), word) != words.end()) return std::string();
            return refusal('"' + word + '"', fmt::format("one of {}", fmt::join(words, ", ")), "Choose one of these") +
                   did_you_mean(word, words);
          },
          shown, "one_of"};
}

CLI::Validator whole_number(unsigned long long low, unsigned long long high) {
  return {[low, high](const std::string& text) {
            const auto value = parsed<unsigned long long>(text);
            if (value && *value >= low && *value <= high) return std::string();
            return refusal(text, fmt::format("a whole number from {} to {}", low, high),
                           "Correct the number, or leave the flag out");
          },
          "", "whole_number"};
}

CLI::Validator positive_number() {
  return {[](const std::string& text) {
            const auto value = parsed<double>(text);
            if (value && std::isfinite(*value) && *value > 0.0) return std::string();
            return refusal(text, "a number above 0", "Correct the number, or leave the flag out");
          },
          "", "positive_number"};
}

CLI::Validator number_between(double low, double high, std::string what_to_do) {
  return {[low, high, what_to_do](const std::string& text) {
            const auto value = parsed<double>(text);
            if (value && *value >= low && *value <= high) return std::string();
            return refusal(text, fmt::format("a number from {:g} to {:g}", low, high), what_to_do);
          },
          "", "number_between"};
}

CLI::Validator number_from_zero() {
  return {[](const std::string& text) {
            const auto value = parsed<double>(text);
            if (value && std::isfinite(*value) && *value >= 0.0) return std::string();
            return refusal(text, "a number of 0 or more", "Correct the number, or leave the flag out");
          },
          "", "number_from_zero"};
}

CLI::Validator some_name(std::string expected) {
  return {[expected](const std::string& name) {
            return name.empty() ? refusal("an empty name", expected, "Give one, or leave the flag out") : std::string();
          },
          "", "some_name"};
}

CLI::Option* add_output_file(CLI::App& command, const std::string& flag, std::string& file, const std::string& help) {
  return command.add_option(flag, file, help)
      ->type_name("FILE")
      ->check(some_name("a path, or - for standard output"));
}

namespace {

/// Two names of one file, by whatever spelling.
bool is_one_file(const std::string& a, const std::string& b) {
  if (a == b) return true;
  std::error_code error;
  const std::filesystem::path first = std::filesystem::weakly_canonical(std::filesystem::absolute(a, error), error);
  const std::filesystem::path second = std::filesystem::weakly_canonical(std::filesystem::absolute(b, error), error);
  return !error && first == second;
}

}  // namespace

void refuse_shared_files(const std::vector<std::pair<std::string, std::string>>& file_of_flag) {
  for (std::size_t k = 0; k < file_of_flag.size(); ++k) {
    for (std::size_t other = 0; other < k; ++other) {
      const std::string &one = file_of_flag[k].second, &two = file_of_flag[other].second;
      if (one.empty() || two.empty() || !is_one_file(one, two)) continue;
      throw InputError(fmt::format("{}, {}", file_of_flag[other].first, file_of_flag[k].first),
                       "one file for two results", "a file for each", "Give different names");
    }
  }
}

std::FILE* summary_stream(std::initializer_list<std::string> result_files) {
  return std::find(result_files.begin(), result_files.end(), AtomicFile::kStandardOutput) != result_files.end()
             ? stderr
             : stdout;
}

std::string usage_message(const CLI::App* app, const CLI::Error& error) {
  const CLI::App& command = active(*app);
  const std::string said = error.what();
  const std::string help = fmt::format("`{} --help`", words_to(command));
  const bool none_chosen = !command.get_subcommands(nullptr).empty();
  std::string text;
  if (none_chosen) {
    text = unknown_command(command, &command == app ? "command line" : title_of(command), help);
  } else if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    text = unknown_argument(command, help);
  } else if (dynamic_cast<const CLI::ExcludesError*>(&error) != nullptr) {
    const auto [one, other] = two_names(said, " excludes ");
    text = fmt::format("{}: found together with {}; expected one of the two. Leave one out.", one, other);
  } else if (dynamic_cast<const CLI::RequiresError*>(&error) != nullptr) {
    const auto [one, other] = two_names(said, " requires ");
    text = fmt::format("{}: found without {}; expected both. Add {}, or leave {} out.", one, other, other, one);
  } else if (dynamic_cast<const CLI::ValidationError*>(&error) != nullptr) {
    text = said;
  } else if (said.ends_with(" missing") || said.ends_with(" is required")) {
    text = missing_value(said, help);
  } else {
    text = fmt::format("{}: found a command line that cannot be used ({}); expected what {} shows. Correct the flag.",
                       title_of(command), said, help);
  }
  return fmt::format("voltlap: {}\n", text);
}

}  // namespace voltlap::plant
