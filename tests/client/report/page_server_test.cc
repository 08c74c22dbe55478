#include "client/report/page_server.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class PageServerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto server = PageServer::Create(0, "<p>a page</p>", shelf_);
    ASSERT_TRUE(server.ok()) << server.status();
    url_ = server->url();
    const size_t slash = url_.find('/', 7);
    host_ = url_.substr(7, slash - 7);
    path_ = url_.substr(slash);
    thread_ = std::jthread([server = *std::move(server)](const std::stop_token& stop) mutable { server.Serve(stop); });
  }

  int Connect() const {
    const int descriptor = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<uint16_t>(std::stoi(host_.substr(host_.find(':') + 1))));
    EXPECT_EQ(connect(descriptor, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    return descriptor;
  }

  // Sends the pieces, and returns all that comes back until the server hangs up.
  std::string Ask(const std::vector<std::string>& pieces) const { return AskOver(Connect(), pieces); }

  static std::string AskOver(int descriptor, const std::vector<std::string>& pieces) {
    // The server may hang up before it has read all.
    for (const std::string& piece : pieces) (void)send(descriptor, piece.data(), piece.size(), MSG_NOSIGNAL);
    std::string answer;
    char bytes[4096];
    for (ssize_t count; (count = recv(descriptor, bytes, sizeof(bytes), 0)) > 0;) {
      answer.append(bytes, static_cast<size_t>(count));
    }
    close(descriptor);
    return answer;
  }

  std::string Request(const std::string& method, const std::string& path, const std::string& host) const {
    return Ask({absl::StrCat(method, " ", path, " HTTP/1.1\r\nHost: ", host, "\r\n\r\n")});
  }

  const std::shared_ptr<ReportShelf> shelf_ = std::make_shared<ReportShelf>();
  std::string url_, host_, path_;
  std::jthread thread_;
};

TEST_F(PageServerTest, GivesThePageToWhoKnowsItsAddress) {
  EXPECT_EQ(path_.size(), 33u);
  EXPECT_THAT(
      Request("GET", path_, host_),
      AllOf(StartsWith("HTTP/1.1 200 OK\r\n"), HasSubstr("Content-Length: 13\r\n"), EndsWith("\r\n\r\n<p>a page</p>")));
  EXPECT_THAT(Request("HEAD", path_, host_), AllOf(StartsWith("HTTP/1.1 200 OK\r\n"), EndsWith("\r\n\r\n")));
}

TEST_F(PageServerTest, GivesTheReportOfTheShelf) {
  EXPECT_THAT(Request("GET", path_ + "/report", host_), StartsWith("HTTP/1.1 404")) << "there is none so far";
  const auto points = std::make_shared<GrowingBytes>(6);
  points->Append("abc");
  shelf_->Put({.generation = 7, .report = "{}", .points = points});
  EXPECT_THAT(Request("GET", path_ + "/report", host_), EndsWith("\r\n\r\n{}"));
  EXPECT_THAT(Request("GET", path_ + "/generation", host_), EndsWith("\r\n\r\n7"));
  EXPECT_THAT(Request("GET", path_ + "/points/6", host_), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Request("GET", path_ + "/points/7", "example.com"), StartsWith("HTTP/1.1 421"));
  EXPECT_THAT(Request("HEAD", path_ + "/points/7", host_),
              AllOf(HasSubstr("Content-Length: 6\r\n"), EndsWith("\r\n\r\n")));
  // The answer ends once the rest has come.
  std::string answer;
  std::thread asking([&] { answer = Request("GET", path_ + "/points/7", host_); });
  EXPECT_THAT(Request("GET", path_ + "/generation", host_), EndsWith("7")) << "others are served meanwhile";
  points->Append("def");
  asking.join();
  EXPECT_THAT(answer, EndsWith("\r\n\r\nabcdef"));
}

TEST_F(PageServerTest, EndsWhilePointsAreWaitedFor) {
  shelf_->Put({.generation = 1, .report = "{}", .points = std::make_shared<GrowingBytes>(6)});
  std::string answer;
  // Connected before the stop, after which there is nobody to connect to, however late this thread starts.
  std::thread asking([&, descriptor = Connect()] {
    answer = AskOver(descriptor, {absl::StrCat("GET ", path_, "/points/1 HTTP/1.1\r\nHost: ", host_, "\r\n\r\n")});
  });
  // Once this is answered, or even before, the stop finds somebody who waits.
  Request("GET", path_ + "/generation", host_);
  thread_.request_stop();
  asking.join();
  EXPECT_THAT(answer, Not(HasSubstr("\r\n\r\na")));
}

TEST_F(PageServerTest, RefusesEverythingElse) {
  EXPECT_THAT(Request("GET", "/", host_), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Request("GET", path_ + "0", host_), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Request("POST", path_, host_), StartsWith("HTTP/1.1 405"));
  // A name that somebody else made lead here.
  EXPECT_THAT(Request("GET", path_, "example.com"), StartsWith("HTTP/1.1 421"));
  EXPECT_THAT(Ask({"GET " + path_ + " HTTP/1.1\r\n\r\n"}), StartsWith("HTTP/1.1 421"));
  EXPECT_THAT(Ask({"GET " + path_ + " HTTP/1.1\r\nHost: a\r\nHost: " + host_ + "\r\n\r\n"}),
              StartsWith("HTTP/1.1 421"));
  EXPECT_THAT(Ask({"nonsense\r\n\r\n"}), StartsWith("HTTP/1.1 400"));
  EXPECT_EQ(Ask({std::string(100'000, 'a')}), "");
}

TEST_F(PageServerTest, TakesRequestsInPiecesBesideSilentConnections) {
  std::vector<int> silent;
  for (int i = 0; i < 5; ++i) silent.push_back(Connect());
  EXPECT_THAT(Ask({"GET " + path_, " HTTP/1.1\r\nhost:" + host_, "\r\n", "\r\n"}), StartsWith("HTTP/1.1 200 OK"));
  for (const int descriptor : silent) close(descriptor);
}

TEST(PageServerPortTest, NamesAPortThatIsTaken) {
  const auto first = PageServer::Create(0, "");
  ASSERT_TRUE(first.ok());
  const std::string url = first->url();
  const int port = std::stoi(url.substr(url.find(':', 7) + 1));
  const auto second = PageServer::Create(static_cast<uint16_t>(port), "");
  EXPECT_THAT(second.status().message(), AllOf(HasSubstr("--port"), HasSubstr(absl::StrCat(port))));
  EXPECT_NE(first->url(), PageServer::Create(0, "")->url());
}

}  // namespace
}  // namespace curv
