// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.hpp"

#include <sstream>
#include <zlib.h>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using voltlap::plant::AtomicFile;

namespace {

std::string content(const std::string& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

}  // namespace

TEST_GROUP(AtomicFile) {
  Scratch scratch;
};

TEST(AtomicFile, IsThereAfterCommitAndNotBefore) {
  AtomicFile file(scratch.file("result"));
  file.write("one\n");
  file.write("two\n");
  CHECK(!std::filesystem::exists(scratch.file("result")));
  file.commit();
  STRCMP_EQUAL("one\ntwo\n", content(scratch.file("result")).c_str());
  LONGS_EQUAL(1, scratch.files());
}

TEST(AtomicFile, LeavesNothingBehindWithoutCommit) {
  { AtomicFile(scratch.file("result")).write("half"); }
  LONGS_EQUAL(0, scratch.files());
}

TEST(AtomicFile, CompleteFileHasItsNameOnlyAfterCommit) {
  scratch.write("result", "earlier");
  AtomicFile file(scratch.file("result"));
  file.write("new");
  file.complete();
  STRCMP_EQUAL("earlier", content(scratch.file("result")).c_str());
  file.commit();
  STRCMP_EQUAL("new", content(scratch.file("result")).c_str());
  LONGS_EQUAL(1, scratch.files());
}

TEST(AtomicFile, CompleteFileThatIsNotCommittedLeavesNothing) {
  {
    AtomicFile file(scratch.file("result"));
    file.write("new");
    file.complete();
  }
  LONGS_EQUAL(0, scratch.files());
}

TEST(AtomicFile, KeepsTheEarlierFileWhenTheNewOneIsNotCommitted) {
  scratch.write("result", "earlier");
  { AtomicFile(scratch.file("result")).write("half"); }
  STRCMP_EQUAL("earlier", content(scratch.file("result")).c_str());
}

TEST(AtomicFile, NameThatEndsInGzIsCompressed) {
  AtomicFile file(scratch.file("result.gz"));
  file.write("squeezed");
  file.commit();
  char text[16] = {};
  gzFile gzip = gzopen(scratch.file("result.gz").c_str(), "rb");
  LONGS_EQUAL(8, gzread(gzip, text, sizeof text));
  CHECK_FALSE(gzdirect(gzip));
  gzclose(gzip);
  STRCMP_EQUAL("squeezed", text);
}

TEST(AtomicFile, FolderThatDoesNotExistIsNamed) {
  const std::string message = complaint([&] { AtomicFile file(scratch.file("absent/result")); });
  STRCMP_CONTAINS("absent/result: cannot open", message.c_str());
  STRCMP_CONTAINS("No such file or directory", message.c_str());
}

TEST(AtomicFile, FolderInsteadOfAFileIsRefused) {
  STRCMP_CONTAINS("Is a directory", complaint([&] { AtomicFile file(scratch.file("")); }).c_str());
}

TEST(AtomicFile, FullDiskIsReportedAtTheLatestByCommit) {
  const std::string message = complaint([] {
    AtomicFile file("/dev/full");
    file.write("x");
    file.commit();
  });
  STRCMP_CONTAINS("No space left on device", message.c_str());
}

TEST(AtomicFile, FullDiskIsReportedWhileWritingMuch) {
  const std::string block(1 << 20, 'x');
  AtomicFile file("/dev/full");
  STRCMP_CONTAINS("No space left on device", complaint([&] { file.write(block); }).c_str());
}
