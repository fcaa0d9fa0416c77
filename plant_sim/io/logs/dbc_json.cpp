// SPDX-License-Identifier: Apache-2.0
#include "io/logs/dbc_json.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "core/errors.hpp"
#include "core/input_files.hpp"
#include "io/atomic_file.hpp"
#include "io/python_module.hpp"

namespace voltlap::plant {
namespace {

namespace fs = std::filesystem;

constexpr int kFormat = 5;  // FORMAT in dbc_json.py
constexpr std::uintmax_t kMostBytes = 32'000'000;
constexpr std::size_t kLargeBytes = 500'000;  // from here on it takes seconds

std::string sha256(std::string_view text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned size = 0;
  if (EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("the SHA-256 of the cryptography library failed");
  }
  std::string out;
  for (unsigned k = 0; k < size; ++k) out += fmt::format("{:02x}", digest[k]);
  return out;
}

std::optional<std::string> content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::string text(std::istreambuf_iterator<char>(file), {});
  if (file.bad()) return std::nullopt;
  return text;
}

std::string dbc_content(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = fs::is_directory(path, error) ? 0 : fs::file_size(path, error);
  const char* found = error                           ? "a file that cannot be opened"
                      : fs::is_directory(path, error) ? "a folder"
                      : size > kMostBytes             ? "more than 32 MB"
                                                      : nullptr;
  std::optional<std::string> text;
  if (found == nullptr) text = content_of(path);
  if (!text) {
    throw InputError(path, found != nullptr ? found : "a file that cannot be read", "a DBC file",
                     "Correct the path, or check that this is the file you meant");
  }
  note_input(path);
  return *text;
}

/// Folder of the cache; empty where there is none.
fs::path cache_folder() {
  if (const char* named = std::getenv("XDG_CACHE_HOME"); named != nullptr && named[0] == '/') {
    return fs::path(named) / "voltlap" / "dbc";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && home[0] == '/') {
    return fs::path(home) / ".cache" / "voltlap" / "dbc";
  }
  return {};
}

/// The entry is the hash of what follows on a line of its own, then that: a damaged one is none.
std::optional<std::string> cached(const fs::path& entry) {
  auto text = content_of(entry);
  if (!text) return std::nullopt;
  const std::size_t end = text->find('\n');
  if (end == std::string::npos) return std::nullopt;
  std::string json = text->substr(end + 1);
  if (text->substr(0, end) != fmt::format("{{\"sha256\": \"{}\"}}", sha256(json))) return std::nullopt;
  return json;
}

/// Without a folder that can be written there is no cache, which only costs time.
void store(const fs::path& entry, const std::string& json) {
  std::error_code error;
  fs::create_directories(entry.parent_path(), error);
  if (error) return;
  try {
    AtomicFile file(entry.string());
    file.write(fmt::format("{{\"sha256\": \"{}\"}}\n", sha256(json)));
    file.write(json);
    file.commit();
  } catch (const OutputError&) {
  } catch (const InputError&) {
  }
}

}  // namespace

std::string dbc_json(const std::string& path) {
  const std::string content = dbc_content(path);
  const std::string kind = fs::path(path).extension().string();
  const fs::path folder = cache_folder();
  const fs::path entry = folder / (sha256(fmt::format("{} {}\n{}", kFormat, kind, content)) + ".json");
  if (!folder.empty()) {
    if (auto json = cached(entry)) return *std::move(json);
  }
  if (content.size() > kLargeBytes) fmt::print(stderr, "{}: read by cantools, once; this takes a while\n", path);
  std::string json = run_python_module("voltlap_logs.dbc_json", {fs::absolute(path).string()});
  if (!folder.empty()) store(entry, json);
  return json;
}

}  // namespace voltlap::plant
