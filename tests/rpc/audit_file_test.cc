// The file of the audit log, and kerfd --audit-log.

#include "server/app/audit_file.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/rpc/kerfd_process.h"

namespace kerf::rpc_test {
namespace {

using ::testing::HasSubstr;

class AuditFileTest : public KerfdTest {
 protected:
  [[nodiscard]] std::string read(const std::string& name) const {
    std::ifstream file(folder_ / name);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  const std::string path_ = (folder_ / "audit.log").string();
};

TEST_F(AuditFileTest, AppendsToWhatIsThere) {
  write("audit.log", "before\n");
  const auto file = app::AuditFile::open(path_).value();
  EXPECT_TRUE(file->append("one\n"));
  EXPECT_TRUE(file->append("two\n"));
  EXPECT_EQ(read("audit.log"), "before\none\ntwo\n");
}

TEST_F(AuditFileTest, ANewFileIsForItsOwnerAlone) {
  const auto file = app::AuditFile::open(path_).value();
  EXPECT_EQ(std::filesystem::status(path_).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

TEST_F(AuditFileTest, ContinuesInANewFileAfterTheOldOneWasRenamed) {
  const auto file = app::AuditFile::open(path_).value();
  EXPECT_TRUE(file->append("one\n"));
  std::filesystem::rename(path_, path_ + ".1");
  EXPECT_TRUE(file->append("two\n"));
  EXPECT_TRUE(file->reopen().ok());
  EXPECT_TRUE(file->append("three\n"));
  EXPECT_EQ(read("audit.log.1"), "one\ntwo\n");
  EXPECT_EQ(read("audit.log"), "three\n");
}

TEST_F(AuditFileTest, SaysWhenItCannotWrite) {
  EXPECT_EQ(app::AuditFile::open((folder_ / "none" / "audit.log").string()).error().reason, "BAD_AUDIT_LOG");
  if (!std::filesystem::exists("/dev/full")) return;
  const auto full = app::AuditFile::open("/dev/full").value();
  EXPECT_FALSE(full->append("one\n"));
}

TEST_F(AuditFileTest, KerfdWritesItAndOpensItAgainOnSighup) {
  EXPECT_THAT(refusal(free_ports({"--audit-log", (folder_ / "none" / "a").string()})), HasSubstr("--audit-log"));
  Kerfd kerfd(free_ports({"--audit-log", path_, "--data", "none"}));
  const int port = ports(kerfd).second;
  const auto pause = [port] {
    return ws_test::request(port, "POST", "/kerf.v1.SheetService/CreateSheet", "Content-Type: application/json\r\n",
                            R"({"scene":{"grid":{"columns":3,"rows":3,"width_m":1,"height_m":1}},"paused":true})")
        .status;
  };
  EXPECT_EQ(pause(), 200);
  const std::string line = read("audit.log");
  EXPECT_THAT(line, HasSubstr(R"("call":"CreateSheet","outcome":"OK")"));
  EXPECT_THAT(line, HasSubstr(R"("sheet":"sheet-)")) << "the id that the server chose";
  std::filesystem::rename(path_, path_ + ".1");
  kerfd.signal(SIGHUP);
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kPatienceMs);
  while (!std::filesystem::exists(path_)) ASSERT_LT(std::chrono::steady_clock::now(), end);
  EXPECT_EQ(pause(), 200);
  EXPECT_THAT(read("audit.log"), HasSubstr("CreateSheet"));
  EXPECT_EQ(read("audit.log.1"), line);
}

}  // namespace
}  // namespace kerf::rpc_test
