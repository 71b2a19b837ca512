// The file of tokens, and new tokens.

#include "server/service/auth/token_file.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kerf::auth {
namespace {

using testing::HasSubstr;

const std::string kDigest(64, 'a');

TEST(TokenFile, HasALineForEachToken) {
  const auto tokens = parse_token_file("# who\n\nalice " + kDigest +
                                       " scope=cut sheets=lab-* until=2027-03-01  # for the lab\r\n"
                                       "  bob\t" +
                                       kDigest + " scope=view");
  ASSERT_TRUE(tokens.ok()) << tokens.error().message;
  ASSERT_EQ(tokens->tokens.size(), 2u);
  EXPECT_EQ(tokens->tokens.at(0).id, "alice");
  EXPECT_EQ(to_hex(tokens->tokens.at(0).digest), kDigest);
  EXPECT_EQ(tokens->tokens.at(0).rights.scope, Scope::kCut);
  EXPECT_EQ(tokens->tokens.at(0).rights.sheets, "lab-*");
  EXPECT_EQ(tokens->tokens.at(0).rights.until_unix_s, 1'803'859'200);  // date -u -d 2027-03-01 +%s
  EXPECT_EQ(tokens->tokens.at(1).rights.scope, Scope::kView);
  EXPECT_EQ(tokens->tokens.at(1).rights.sheets, "*");
  EXPECT_EQ(tokens->tokens.at(1).rights.until_unix_s, 0);
  EXPECT_TRUE(parse_token_file("")->tokens.empty());
}

TEST(TokenFile, NamesTheLineThatIsWrong) {
  const std::string good = "alice " + kDigest + " scope=cut";
  for (const auto& [line, says] : {std::pair<std::string, const char*>("bob", "ID SHA-256"),
                                   {"bob " + kDigest, "ID SHA-256"},
                                   {"Bob " + kDigest + " scope=cut", "an id has"},
                                   {"-b " + kDigest + " scope=cut", "an id has"},
                                   {std::string(33, 'b') + " " + kDigest + " scope=cut", "an id has"},
                                   {"bob abc scope=cut", "64 hexadecimal"},
                                   {"bob " + std::string(63, 'a') + "g scope=cut", "64 hexadecimal"},
                                   {"bob " + kDigest + " scope=root", "view, cut"},
                                   {"bob " + kDigest + " sheets=a", "scope=view"},
                                   {"bob " + kDigest + " scope=cut scope=view", "twice"},
                                   {"bob " + kDigest + " scope=cut sheets=A", "pattern"},
                                   {"bob " + kDigest + " scope=cut sheets=", "pattern"},
                                   {"bob " + kDigest + " scope=cut until=tomorrow", "YYYY-MM-DD"},
                                   {"bob " + kDigest + " scope=cut until=2027-02-29", "YYYY-MM-DD"},
                                   {"bob " + kDigest + " scope=cut until=20270-2-9", "YYYY-MM-DD"},
                                   {"bob " + kDigest + " scope=cut x=y", "none of"},
                                   {"bob " + kDigest + " scope=cut tenant=", "name of a tenant"},
                                   {"bob " + kDigest + " scope=cut tenant=lab sheets=shop-*", "begin with lab-"},
                                   {"tenant " + kDigest + " scope=cut", "a tenant's name"},
                                   {"tenant", "a tenant's name"},
                                   {"tenant sheet", "choose another name"},
                                   {"tenant 1lab", "a tenant's name"},
                                   {"tenant lab-a", "a tenant's name"},
                                   {"tenant " + std::string(17, 'a'), "a tenant's name"},
                                   {"tenant lab sheets=-1", "sheets must be"},
                                   {"tenant lab sheets=1.5", "a whole one"},
                                   {"tenant lab vertices=1e3", "vertices must be"},
                                   {"tenant lab workers=nan", "workers must be"},
                                   {"tenant lab streams=2000000000", "streams must be"},
                                   {"tenant lab cuts-per-s=", "cuts-per-s must be"},
                                   {"tenant lab sheets=1 sheets=2", "twice"},
                                   {"tenant lab x=1", "none of"},
                                   {good, "the id is there twice"}}) {
    const auto tokens = parse_token_file(good + "\n# a comment\n" + line + "\n");
    ASSERT_FALSE(tokens.ok()) << line;
    EXPECT_EQ(tokens.error().reason, "BAD_TOKEN_FILE");
    EXPECT_THAT(tokens.error().message, HasSubstr("line 3: ")) << line;
    EXPECT_THAT(tokens.error().message, HasSubstr(says)) << line;
  }
}

TEST(TokenFile, HasTenantsWithTheirLimits) {
  const auto file = parse_token_file("alice " + kDigest + " scope=cut tenant=lab\n" +
                                     "tenant lab sheets=3 vertices=0 state-mib=2 workers=0.5 streams=4 image-streams=1 "
                                     "cuts-per-s=2.5\n" +
                                     "bob " + kDigest + " scope=view sheets=lab-b* tenant=lab\ntenant shop\n");
  ASSERT_TRUE(file.ok()) << file.error().message;
  ASSERT_EQ(file->tenants.size(), 2u);
  EXPECT_EQ(file->tenants[0].name, "lab");
  EXPECT_EQ(file->tenants[0].limits, (TenantLimits{3, 0, 2 << 20, 0.5, 4, 1, 2.5}));
  EXPECT_EQ(file->tenants[1].limits, TenantLimits());
  EXPECT_EQ(file->tokens[0].rights.tenant, "lab");
  EXPECT_EQ(file->tokens[0].rights.sheets, "lab-*");
  EXPECT_EQ(file->tokens[1].rights.sheets, "lab-b*");
  const auto missing = parse_token_file("alice " + kDigest + " scope=cut tenant=lab\n");
  ASSERT_FALSE(missing.ok());
  EXPECT_THAT(missing.error().message, HasSubstr("add `tenant lab`"));
  EXPECT_THAT(parse_token_file("tenant lab\ntenant lab").error().message,
              HasSubstr("line 2: the tenant is there twice"));
}

TEST(TokenFile, TakesNewTokens) {
  const NewToken made = make_token({"alice", Scope::kCut, "lab-*", "2027-03-01", ""}).value();
  const Token token = parse_token_file(made.line).value().tokens.at(0);
  EXPECT_EQ(token.id, "alice");
  EXPECT_EQ(id_in(made.text), "alice");
  EXPECT_EQ(token.digest, digest_of(made.text));
  EXPECT_EQ(made.line.find(made.text.substr(11)), std::string::npos) << "the line has no secret";
  EXPECT_NE(make_token({"alice", Scope::kCut, "", "", ""}).value().text,
            make_token({"alice", Scope::kCut, "", "", ""}).value().text);
  EXPECT_EQ(parse_token_file("tenant lab\n" + make_token({"a", Scope::kCut, "", "", "lab"}).value().line)
                .value()
                .tokens.at(0)
                .rights.tenant,
            "lab");
  for (const TokenWish& wish :
       {TokenWish{"", Scope::kView, "", "", ""}, TokenWish{"a b", Scope::kView, "", "", ""},
        TokenWish{"a", Scope::kView, "a b", "", ""}, TokenWish{"a", Scope::kView, "a#b", "", ""},
        TokenWish{"a", Scope::kView, "", "soon", ""}, TokenWish{"#a", Scope::kView, "", "", ""},
        TokenWish{"tenant", Scope::kView, "", "", ""}, TokenWish{"a", Scope::kView, "", "", "lab x"},
        TokenWish{"a", Scope::kView, "shop-*", "", "lab"}}) {
    EXPECT_EQ(make_token(wish).error().reason, "BAD_TOKEN") << wish.id << wish.sheets << wish.until << wish.tenant;
  }
}

TEST(TokenFile, ATextThatIsNoTokenHasNoId) {
  const std::string secret(43, 'A');
  EXPECT_EQ(id_in("kerf_a_" + secret), "a");
  for (const std::string& text :
       {std::string(), std::string("kerf_"), std::string("kerf_a"), "kerf__" + secret, "Kerf_a_" + secret,
        "kerf_a_" + secret + "x", "kerf_A_" + secret, " kerf_a_" + secret}) {
    EXPECT_EQ(id_in(text), "") << text;
  }
}

TEST(Secrets, AreHashedAsOthersDo) {
  EXPECT_EQ(to_hex(digest_of("abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");  // FIPS 180-4
  std::set<std::string> secrets;
  for (int i = 0; i < 100; ++i) secrets.insert(new_secret());
  EXPECT_EQ(secrets.size(), 100u);
  EXPECT_EQ(secrets.begin()->size(), 43u);
}

}  // namespace
}  // namespace kerf::auth
