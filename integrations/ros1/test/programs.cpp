#include "ros1/test/programs.h"

#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace catan_ros {

std::string text_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

ProgramsTest::ProgramsTest() {
  folder_ = testing::TempDir() + "catan-ros1-XXXXXX";
  if (::mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("no folder " + folder_);
  roscore_ = std::make_unique<Roscore>(folder_);
}

ProgramsTest::~ProgramsTest() {
  while (!processes_.empty()) end(processes_.front(), SIGTERM);
  roscore_.reset();
  std::filesystem::remove_all(folder_);
}

int ProgramsTest::start(const std::string& name, const std::string& command) {
  const int process = ::fork();
  if (process == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    const std::string line =
        "cd " + folder_ + " && exec " + command + " > " + name + ".out 2> " + name + ".err < /dev/null";
    ::execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    ::_exit(127);
  }
  processes_.push_back(process);
  return process;
}

int ProgramsTest::start_node(const std::string& name, const std::string& arguments) {
  return start(name, std::string(PLAIN_NODE) + " " + name + " " + arguments + " --counts " + name + ".json");
}

int ProgramsTest::start_under_catan(const std::string& arguments) {
  return start("run", std::string(CATAN_COMMAND) + " ros run app.yaml --bind bind.yaml " + arguments);
}

int ProgramsTest::end(int process, int signal) {
  ::kill(process, signal);
  return wait(process, std::chrono::seconds{15});
}

int ProgramsTest::wait(int process, Milliseconds timeout) {
  const auto until = std::chrono::steady_clock::now() + timeout;
  int status = 0;
  while (::waitpid(process, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > until) {
      ::kill(process, SIGKILL);
      ::waitpid(process, &status, 0);
      std::erase(processes_, process);
      return 255;
    }
    std::this_thread::sleep_for(Milliseconds{10});
  }
  std::erase(processes_, process);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

long ProgramsTest::counted(const std::string& node, const std::string& what) const {
  const Json counts = Json::parse(text_of(path(node + ".json")), nullptr, false);
  return counts.is_object() ? counts.value(what, 0L) : 0;
}

bool ProgramsTest::counts(const std::string& node, const std::string& what, long more, Milliseconds within) const {
  const long goal = counted(node, what) + more;
  const auto until = std::chrono::steady_clock::now() + within;
  while (counted(node, what) < goal) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(Milliseconds{20});
  }
  return true;
}

void ProgramsTest::write_app_of_work(const std::string& keys, const std::string& more) const {
  write("app.yaml", "catan: 1\napp: worker\nnodes: { work: { " + keys +
                        " } }\nobjective: [ { period: work, weight: 1 } ]\n" + more);
}

void ProgramsTest::write_binding_of_work(const std::string& ros_node, const std::string& file,
                                         const std::string& callback) const {
  write(file, "catan: 1\nros: { work: { node: " + ros_node + ", " + callback + " } }\n");
}

void ProgramsTest::write_app_of_nodelets(const std::string& camera, const std::string& others) const {
  write("app.yaml", "catan: 1\napp: nodelets\nnodes: { camera: { " + camera + " }, detect: { " + others +
                        " }, follow: { " + others + R"( } }
edges: [ camera -> detect -> follow ]
objective: [ { response_time: [camera, detect, follow], weight: 1 } ]
scheduler: { bootstrap: 300ms }
)");
  write("bind.yaml", R"(catan: 1
ros:
  camera: { node: /manager, timer: 20ms }
  detect: { node: /manager, topic: /images }
  follow: { node: /manager, topic: /things }
)");
}

void ProgramsTest::write_script(const std::string& text) const {
  write("launch.sh", "#!/bin/sh\n" + text);
  std::filesystem::permissions(path("launch.sh"), std::filesystem::perms::owner_all);
}

void ProgramsTest::write_launcher(const std::vector<std::string>& lines) const {
  std::string text;
  for (const std::string& line : lines) text += std::string(PLAIN_NODE) + " " + line + " &\n";
  write_script(text + "wait\n");
}

void ProgramsTest::write_talker(const std::string& topic, const std::string& type) const {
  write("talker.py",
        "import rospy, std_msgs.msg\n"
        "rospy.init_node('talker')\n"
        "out = rospy.Publisher('" +
            topic + "', std_msgs.msg." + type +
            ", queue_size=1)\n"
            "open('talks', 'w').close()\n"
            "rate = rospy.Rate(20)\n"
            "while not rospy.is_shutdown():\n"
            "    out.publish(1)\n"
            "    rate.sleep()\n");
}

ProgramsTest::Json ProgramsTest::node(const Json& report, const std::string& name) {
  for (const Json& entry : report["nodes"]) {
    if (entry["node"] == name) return entry;
  }
  return Json::object();
}

}  // namespace catan_ros
