#include "client/cli/completion.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cli/app.h"

namespace kerf::cli {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

class CompletionTest : public testing::Test {
 protected:
  Completion complete_words(const std::vector<std::string>& words) {
    return complete(*app_, words, {"default:1", {.tls_cert = "default.pem"}},
                    {[this](const ServerTarget& server) {
                       asked_ = server;
                       return std::vector<std::string>{"alpha", "beta"};
                     },
                     [](const ServerTarget& /*server*/) {
                       return std::vector<std::string>{"wool", "denim"};
                     }});
  }
  std::vector<std::string> offered(const std::vector<std::string>& words) {
    std::vector<std::string> found;
    for (const Candidate& candidate : complete_words(words).candidates) found.push_back(candidate.word);
    return found;
  }

  Session session_;
  std::unique_ptr<CLI::App> app_ = make_app(session_);
  ServerTarget asked_;
};

TEST_F(CompletionTest, OffersWhatBeginsWithTheLastWord) {
  EXPECT_THAT(offered({"sheet", "re"}), ElementsAre("release", "restore", "record", "resume", "reset"));
  EXPECT_THAT(offered({"cut", "a", "--bez"}), ElementsAre("--bezier"));
  EXPECT_THAT(offered({}), Contains("sheet"));
  EXPECT_THAT(offered({"sheet", "create", "a", "--pin", "t"}), ElementsAre("top"));
  EXPECT_THAT(offered({"sheet", "create", "a", "--pin=t"}), ElementsAre("--pin=top"));
}

TEST_F(CompletionTest, ValuesOfOptionsAreNoArguments) {
  EXPECT_THAT(offered({"sheet", "create", "--grid", "sheet", "a", "--material", ""}), ElementsAre("wool", "denim"));
  EXPECT_THAT(offered({"undo", "--server", "undo", ""}), ElementsAre("alpha", "beta"));
  EXPECT_THAT(offered({"undo", "alpha", ""}), IsEmpty());
  EXPECT_THAT(offered({"sheet", "get", "--", "al"}), ElementsAre("alpha"));
  EXPECT_THAT(offered({"sheet", "get", "--", "--js"}), IsEmpty());
}

TEST_F(CompletionTest, TheServerOfTheLineIsAsked) {
  offered({"undo", ""});
  EXPECT_EQ(asked_.address, "default:1");
  offered({"--server", "other:2", "undo", ""});
  EXPECT_EQ(asked_.address, "other:2");
  offered({"undo", "--server=third:3", ""});
  EXPECT_EQ(asked_.address, "third:3");
}

TEST_F(CompletionTest, TheCredentialsOfTheLineAreUsed) {
  offered({"undo", ""});
  EXPECT_EQ(asked_.credentials.tls_cert, "default.pem");
  EXPECT_FALSE(asked_.credentials.use_tls);
  offered(
      {"--token-file", "token", "--tls", "undo", "--tls-ca=ca.pem", "--tls-cert", "me.pem", "--tls-key", "me.key", ""});
  EXPECT_EQ(asked_.credentials.token_file, "token");
  EXPECT_TRUE(asked_.credentials.use_tls);
  EXPECT_EQ(asked_.credentials.tls_ca, "ca.pem");
  EXPECT_EQ(asked_.credentials.tls_cert, "me.pem");
  EXPECT_EQ(asked_.credentials.tls_key, "me.key");
}

TEST_F(CompletionTest, AnOptionIsOfferedOnceUnlessItMayBeRepeated) {
  EXPECT_THAT(offered({"render", "a", "--wireframe", "--"}), Not(Contains("--wireframe")));
  EXPECT_THAT(offered({"sheet", "create", "a", "--part", "x", "--"}), Contains("--part"));
  EXPECT_THAT(offered({"render", "a", "--"}), testing::AllOf(Contains("--json"), Contains("--out")));
}

TEST_F(CompletionTest, FilesAndFoldersAreLeftToTheShell) {
  EXPECT_EQ(complete_words({"run", ""}).paths, Completion::Paths::kFiles);
  EXPECT_EQ(complete_words({"run", "scene.json", "--csv", ""}).paths, Completion::Paths::kFolders);
  EXPECT_EQ(complete_words({"undo", "--token-file", ""}).paths, Completion::Paths::kFiles);
  EXPECT_EQ(complete_words({"sheet", "get", ""}).paths, Completion::Paths::kNone);
}

// An option that names a file or a folder in its help has to complete as one.
void expect_paths(const CLI::App& command) {
  for (const CLI::Option* option : options_of(command)) {
    const std::string& text = option->get_description();
    const bool names_a_path = text.find("this file") != std::string::npos || text.find("File to write") == 0 ||
                              text.find("this folder") != std::string::npos;
    EXPECT_TRUE(!names_a_path || has_values(*option, value::kFile) || has_values(*option, value::kFolder))
        << full_name(command) << " " << option_name(*option);
  }
  for (const CLI::App* below : commands_of(command)) expect_paths(*below);
}

TEST_F(CompletionTest, OptionsThatTakeFilesSaySo) {
  expect_paths(*app_);
}

TEST_F(CompletionTest, LinesCarryTheFirstSentenceOfTheDescription) {
  const std::string lines = to_lines(complete_words({"comp"}));
  EXPECT_EQ(lines, "words\ncompletion\tPrint the script for tab completion of kerf's commands and options\n");
  EXPECT_EQ(to_lines(complete_words({"undo", "b"})), "words\nbeta\n");
}

TEST_F(CompletionTest, ScriptsAreForThreeShells) {
  for (const char* shell : {"bash", "zsh", "fish"}) {
    EXPECT_NE(completion_script(shell).find("__complete"), std::string::npos) << shell;
  }
  EXPECT_EQ(completion_script("csh"), "");
}

}  // namespace
}  // namespace kerf::cli
