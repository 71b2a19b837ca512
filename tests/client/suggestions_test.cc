#include "client/cli/suggestions.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cli/app.h"

namespace kerf::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TEST(Suggestions, NearNamesAreALetterInThreeAway) {
  const std::vector<std::string> names = {"sheet", "cut", "cuts", "watch", "render", "replay", "run"};
  EXPECT_THAT(near_names("shet", names), ElementsAre("sheet"));         // left out
  EXPECT_THAT(near_names("sheeet", names), ElementsAre("sheet"));       // too many
  EXPECT_THAT(near_names("wathc", names), ElementsAre("watch"));        // swapped
  EXPECT_THAT(near_names("remder", names), ElementsAre("render"));      // wrong
  EXPECT_THAT(near_names("ren", names), ElementsAre("render", "run"));  // begun; one letter away
  EXPECT_THAT(near_names("cur", names), ElementsAre("cut"));
  EXPECT_THAT(near_names("fly", names), IsEmpty());
  EXPECT_THAT(near_names("", names), IsEmpty());
}

TEST(Suggestions, AtMostThreeTheNearestFirst) {
  EXPECT_THAT(near_names("sheet-1", {"sheet-12", "sheet-2", "sheet-3", "sheet-4", "sheet-1b"}).size(), 3U);
  EXPECT_THAT(near_names("demo", {"dome", "demos", "demo2"}), ElementsAre("demo2", "demos"));
}

TEST(Suggestions, AreListedAsASentence) {
  EXPECT_EQ(did_you_mean({}), "");
  EXPECT_EQ(did_you_mean({"a"}), "; did you mean a?");
  EXPECT_EQ(did_you_mean({"a", "b"}), "; did you mean a or b?");
  EXPECT_EQ(did_you_mean({"a", "b", "c"}), "; did you mean a, b or c?");
}

std::string explained(std::vector<std::string> words) {
  Session session;
  const auto app = make_app(session);
  std::reverse(words.begin(), words.end());
  try {
    app->parse(words);
  } catch (const CLI::ParseError& error) {
    return explain(*app, error);
  }
  return "was understood";
}

TEST(Suggestions, WrongWordsAreNamedWithWhatWasNear) {
  EXPECT_THAT(explained({"shet", "list"}), HasSubstr("`kerf` has no command \"shet\"; did you mean sheet?"));
  EXPECT_THAT(explained({"sheet", "craete", "a"}),
              HasSubstr("`kerf sheet` has no command \"craete\"; did you mean create?"));
  EXPECT_THAT(explained({"cut", "a", "--bezeir", "0,0 1,1"}),
              HasSubstr("`kerf cut` has no option --bezeir; did you mean --bezier?\nRun `kerf cut --help`"));
  EXPECT_THAT(explained({"sheet", "list", "--jsno"}),
              HasSubstr("`kerf sheet list` has no option --jsno; did you mean --json?"));
  EXPECT_THAT(explained({"undo", "a", "b"}), HasSubstr("`kerf undo` takes no further argument: \"b\""));
  EXPECT_THAT(explained({"sheet", "create", "a", "--gird=4x4"}), HasSubstr("--gird; did you mean --grid?"));
  EXPECT_THAT(explained({"fly"}), Not(HasSubstr("did you mean")));
}

TEST(Suggestions, NamesThatOtherProgramsHaveAreKnown) {
  EXPECT_THAT(explained({"snip", "a"}), HasSubstr("`kerf` has no command \"snip\"; did you mean cut?"));
  EXPECT_THAT(explained({"sheet", "remove", "a"}), HasSubstr("did you mean delete?"));
  EXPECT_THAT(explained({"remove", "a"}), Not(HasSubstr("did you mean")));  // `kerf` itself has no delete
  EXPECT_EQ(explained({"sheet", "ls"}), "was understood");
  EXPECT_EQ(explained({"sheet", "rm", "a"}), "was understood");
}

TEST(Suggestions, OtherMistakesKeepTheirSentence) {
  EXPECT_THAT(explained({"sheet", "create", "a", "--pin", "left"}), HasSubstr("--pin: left not in {"));
  EXPECT_THAT(explained({"undo"}), HasSubstr("ID is required\nRun `kerf undo --help`"));
  EXPECT_EQ(explained({"undo", "a"}), "was understood");
}

}  // namespace
}  // namespace kerf::cli
