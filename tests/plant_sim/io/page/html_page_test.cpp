// SPDX-License-Identifier: Apache-2.0
#include "io/page/html_page.hpp"

#include <stdexcept>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

}  // namespace

TEST_GROUP(HtmlPage) {
  std::string page = html_page({.title = "a < b & \"c\"",
                                .description = "d",
                                .body = "<p>x</p>",
                                .scripts = {"series.js"},
                                .data = R"({"a": "</script><script>"})"});
};

TEST(HtmlPage, TextIsEscaped) {
  STRCMP_CONTAINS("<title>a &lt; b &amp; &quot;c&quot;</title>", page.c_str());
  STRCMP_EQUAL("&#39;&gt;", html_text("'>").c_str());
}

TEST(HtmlPage, NothingInsideDataOrScriptsEndsAScript) {
  LONGS_EQUAL(3, count(page, "<script"));
  LONGS_EQUAL(3, count(page, "</script"));
  STRCMP_CONTAINS(R"({"a": "\u003c/script>\u003cscript>"})", page.c_str());
}

TEST(HtmlPage, LibraryComesWithItsLicencesAndTheBrowserIsToldToLoadNothing) {
  for (const char* words : {"Apache ECharts", "The Apache Software Foundation", "Copyright (c) 2017, Baidu Inc.",
                            "Copyright 2010-2016 Mike Bostock", "default-src 'none'", "<p>x</p>", "<main>",
                            "<noscript>", "voltlap.decode ="}) {
    STRCMP_CONTAINS(words, page.c_str());
  }
}

TEST(HtmlPage, TemplateFillsEachNameAndRefusesAnUnknownOne) {
  STRCMP_EQUAL("1-{{b}}-1", fill_template("{{a}}-{{c}}-{{a}}", {{"a", "1"}, {"c", "{{b}}"}}).c_str());
  CHECK_THROWS(std::out_of_range, static_cast<void>(fill_template("{{b}}", {{"a", "1"}})));
  CHECK_THROWS(std::out_of_range, static_cast<void>(html_asset("absent.js")));
}
