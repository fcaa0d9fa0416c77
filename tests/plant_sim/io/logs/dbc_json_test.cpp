// SPDX-License-Identifier: Apache-2.0
#include "io/logs/dbc_json.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
namespace fs = std::filesystem;

TEST_GROUP(DbcJson) {
  Scratch scratch;
  const std::string path = scratch.write("a.dbc", "BO_ 1 F: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\n");
  TEST_SETUP() { ::setenv("XDG_CACHE_HOME", scratch.file("cache").c_str(), 1); }
  TEST_TEARDOWN() {
    ::unsetenv("XDG_CACHE_HOME");
    ::unsetenv("VOLTLAP_PYTHON");
  }
  fs::path folder() const { return scratch.file("cache/voltlap/dbc"); }
  fs::path entry() const { return fs::directory_iterator(folder())->path(); }
  std::size_t entries() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder()), {})); }
  static void without_python() { ::setenv("VOLTLAP_PYTHON", "/no/such/python", 1); }
};

TEST(DbcJson, FileIsParsedOnceAndNeedsNoPythonAfterwards) {
  const std::string json = dbc_json(path);
  STRCMP_CONTAINS("\"S\"", json.c_str());
  LONGS_EQUAL(1, entries());
  without_python();
  CHECK_EQUAL(json, dbc_json(path));
  CHECK_EQUAL(json, dbc_json(scratch.write("the_same_under_another_name.dbc", "BO_ 1 F: 8 X\n SG_ S : 0|8@1+ (1,0) "
                                                                              "[0|0] \"\" X\n")));
}

TEST(DbcJson, ChangedFileIsParsedAnew) {
  const std::string json = dbc_json(path);
  scratch.write("a.dbc", "BO_ 1 F: 8 X\n SG_ S : 0|8@1+ (2,0) [0|0] \"\" X\n");
  CHECK(json != dbc_json(path));
  LONGS_EQUAL(2, entries());
}

TEST(DbcJson, DamagedEntryIsMadeAgain) {
  const std::string json = dbc_json(path);
  const std::string whole = [&] {
    std::ifstream file(entry());
    return std::string(std::istreambuf_iterator<char>(file), {});
  }();
  std::string flipped = whole;
  flipped[flipped.size() / 2] = static_cast<char>(flipped[flipped.size() / 2] ^ 1);
  for (const std::string& damaged : {std::string(), whole.substr(0, whole.size() / 2), flipped, whole + " "}) {
    std::ofstream(entry()) << damaged;
    CHECK_EQUAL(json, dbc_json(path));
    LONGS_EQUAL(1, entries());
    LONGS_EQUAL(whole.size(), fs::file_size(entry()));
  }
}

TEST(DbcJson, WithoutPythonAndCacheItSaysHowToInstallIt) {
  without_python();
  const std::string text = complaint([&] { (void)dbc_json(path); });
  STRCMP_CONTAINS("/no/such/python: found no Python", text.c_str());
  STRCMP_CONTAINS("pip install -r", text.c_str());
}

TEST(DbcJson, PythonWithoutCantoolsIsNamed) {
  const std::string script = scratch.write("none", "#!/bin/sh\necho \"No module named 'cantools'\" >&2\nexit 3\n");
  fs::permissions(script, fs::perms::owner_all);
  ::setenv("VOLTLAP_PYTHON", script.c_str(), 1);
  const std::string text = complaint([&] { (void)dbc_json(path); });
  STRCMP_CONTAINS("no Python package 'cantools'", text.c_str());
  STRCMP_CONTAINS("pip install -r", text.c_str());
}

TEST(DbcJson, FolderThatCannotBeWrittenIsNoCacheAndNoError) {
  ::setenv("XDG_CACHE_HOME", "/proc/no_folder", 1);
  STRCMP_CONTAINS("\"S\"", dbc_json(path).c_str());
  ::setenv("XDG_CACHE_HOME", scratch.write("a_file", "").c_str(), 1);
  STRCMP_CONTAINS("\"S\"", dbc_json(path).c_str());
}
