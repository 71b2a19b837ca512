#include "client/cli/manual.h"

#include <memory>
#include <regex>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cli/app.h"
#include "server/app/config.h"

namespace kerf::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

// As a reader sees it: without the requests and escapes of man(7).
std::string plain(const std::string& page) {
  std::string text = std::regex_replace(page, std::regex(R"(\\f[BIR])"), "");
  text = std::regex_replace(text, std::regex(R"(\\&)"), "");
  text = std::regex_replace(text, std::regex(R"(\\e)"), "\\");
  return std::regex_replace(text, std::regex(R"(\\-)"), "-");
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

// Each command has a heading, each of its options an entry with what it says of itself.
void expect_in(const std::string& page, const CLI::App& command) {
  if (commands_of(command).empty()) {
    EXPECT_THAT(page, HasSubstr(full_name(command)));
  }
  for (const CLI::Option* option : options_of(command)) {
    if (option == command.get_help_ptr() && command.get_parent() != nullptr) continue;
    EXPECT_THAT(page, testing::ContainsRegex("\n.TP\n[^\n]*" + option_name(*option) + "[ \n]")) << full_name(command);
    EXPECT_THAT(page, HasSubstr(first_line(option->get_description()))) << option_name(*option);
  }
  if (command.get_name() == "load") {
    EXPECT_THAT(page, HasSubstr(command.get_footer()));  // With its lines, as of a table.
  }
  for (const CLI::App* below : commands_of(command)) expect_in(page, *below);
}

const ManualText kText{"kerf", "cuts", "One.\n\nTwo.\n example\n", {{"SEE ALSO", "kerfd(1)"}}};

TEST(Manual, HasEveryCommandAndOptionOfKerf) {
  Session session;
  const auto app = make_app(session);
  const std::string page = plain(manual_page(*app, kText, "1.2"));
  expect_in(page, *app);
  EXPECT_THAT(page, HasSubstr(".SS kerf sheet create ID [OPTION]..."));
  EXPECT_THAT(page, HasSubstr("--pin top|corners|none"));
  EXPECT_THAT(page, HasSubstr("--server HOST:PORT"));
  EXPECT_THAT(page, HasSubstr("Default: 127.0.0.1:50051."));
  EXPECT_THAT(page, HasSubstr("the environment KERF_SERVER); port 50051 unless given.\nDefault:"));
  EXPECT_THAT(page, Not(HasSubstr("__complete")));
}

TEST(Manual, HasTheHelpOptionOnce) {
  Session session;
  const std::string page = plain(manual_page(*make_app(session), kText, "1.2"));
  const std::size_t first = page.find("--help");
  ASSERT_NE(first, std::string::npos);
  EXPECT_EQ(page.find("--help", first + 1), std::string::npos);
}

TEST(Manual, HasEveryOptionOfKerfd) {
  const std::shared_ptr<const CLI::App> app = app::command_line();
  const std::string page = plain(manual_page(*app, {"kerfd", "serves", "Text.", {}}, "1.2"));
  expect_in(page, *app);
  EXPECT_THAT(page, HasSubstr("--tls-client-ca"));
  EXPECT_THAT(page, Not(HasSubstr("COMMAND")));
}

TEST(Manual, TextsAreNotReadAsRequests) {
  CLI::App app("", "kerf");
  double width = 0.0;
  app.add_option("--width-m", width, ".5 is half\n'and this' has an apostrophe, C:\\ a backslash");
  const std::string page = manual_page(app, kText, "1.2");
  EXPECT_THAT(page, HasSubstr("\n\\&.5 is half\n\\&'and this' has an apostrophe, C:\\e a backslash.\n"));
  EXPECT_THAT(page, HasSubstr("\\fB\\-\\-width\\-m\\fR"));
  EXPECT_THAT(page, HasSubstr("One.\n.PP\nTwo.\n.PP\n.nf\n example\n.fi\n"));
  EXPECT_THAT(page, HasSubstr(".SH SEE ALSO\nkerfd(1)\n"));
}

}  // namespace
}  // namespace kerf::cli
