#include "view/window.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "base/terminal.h"
#include "image/canvas.h"

namespace psivox::view {
namespace {

#if IMGUI_VERSION_NUM >= 18900
void set_key(ImGuiIO& io, int key, bool down) { io.AddKeyEvent(static_cast<ImGuiKey>(key), down); }
void set_modifiers(ImGuiIO& io, int modifiers) {
  set_key(io, ImGuiMod_Shift, modifiers & GLFW_MOD_SHIFT);
  set_key(io, ImGuiMod_Ctrl, modifiers & GLFW_MOD_CONTROL);
  set_key(io, ImGuiMod_Alt, modifiers & GLFW_MOD_ALT);
}
#else  // Debian 12's, before it had events
constexpr int ImGuiKey_KeypadEnter = ImGuiKey_KeyPadEnter;
void set_key(ImGuiIO& io, int key, bool down) {
  io.KeyMap[key] = key;
  io.KeysDown[key] = down;
}
void set_modifiers(ImGuiIO& io, int modifiers) {
  io.KeyShift = modifiers & GLFW_MOD_SHIFT;
  io.KeyCtrl = modifiers & GLFW_MOD_CONTROL;
  io.KeyAlt = modifiers & GLFW_MOD_ALT;
}
#endif

constexpr int key_map[][2] = {{ImGuiKey_Tab, GLFW_KEY_TAB},
                              {ImGuiKey_LeftArrow, GLFW_KEY_LEFT},
                              {ImGuiKey_RightArrow, GLFW_KEY_RIGHT},
                              {ImGuiKey_UpArrow, GLFW_KEY_UP},
                              {ImGuiKey_DownArrow, GLFW_KEY_DOWN},
                              {ImGuiKey_PageUp, GLFW_KEY_PAGE_UP},
                              {ImGuiKey_PageDown, GLFW_KEY_PAGE_DOWN},
                              {ImGuiKey_Home, GLFW_KEY_HOME},
                              {ImGuiKey_End, GLFW_KEY_END},
                              {ImGuiKey_Delete, GLFW_KEY_DELETE},
                              {ImGuiKey_Backspace, GLFW_KEY_BACKSPACE},
                              {ImGuiKey_Space, GLFW_KEY_SPACE},
                              {ImGuiKey_Enter, GLFW_KEY_ENTER},
                              {ImGuiKey_Escape, GLFW_KEY_ESCAPE},
                              {ImGuiKey_KeypadEnter, GLFW_KEY_KP_ENTER},
                              {ImGuiKey_A, GLFW_KEY_A},
                              {ImGuiKey_C, GLFW_KEY_C},
                              {ImGuiKey_V, GLFW_KEY_V},
                              {ImGuiKey_X, GLFW_KEY_X},
                              {ImGuiKey_Y, GLFW_KEY_Y},
                              {ImGuiKey_Z, GLFW_KEY_Z}};

constexpr const char* glsl_version = "#version 450 core";

std::string& clipboard_text() {
  static std::string text;
  return text;
}

constexpr auto shown_for = std::chrono::seconds(8);

}  // namespace

Gui::Gui(Window& window) {
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  io.ClipboardUserData = &window;
  io.GetClipboardTextFn = [](void* user) {
    clipboard_text() = static_cast<Window*>(user)->clipboard();
    return clipboard_text().c_str();
  };
  io.SetClipboardTextFn = [](void* user, const char* text) {
    static_cast<Window*>(user)->set_clipboard(text);
  };
  set_scale(window.scale());
  ImGui_ImplOpenGL3_Init(glsl_version);
}

void Gui::set_scale(double scale) {
  scale_ = scale;
  places_panels_ = true;
  constexpr double letters = 13;  // [pixels]
  ImFontConfig font;
  font.FontDataOwnedByAtlas = false;
  const auto& file = image_io::embedded_font();
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  fonts.Clear();
  if (file.empty()) {
    fonts.AddFontDefault();
  } else {
    const std::string& bytes = file.begin()->second;
    fonts.AddFontFromMemoryTTF(const_cast<char*>(bytes.data()), int(bytes.size()),
                               float(std::round(letters * scale)), &font);
  }
  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();
  ImGui::StyleColorsDark();
  style.WindowRounding = 4;
  style.FrameRounding = 2;
  style.Colors[ImGuiCol_WindowBg].w = 0.85f;
  style.ScaleAllSizes(float(scale));
}

Gui::~Gui() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

void Gui::feed(const Event& event) {
  ImGuiIO& io = ImGui::GetIO();
  using Kind = Event::Kind;
  switch (event.kind) {
    case Kind::button:
      if (event.code >= 0 && event.code < int(down_.size())) {
        const auto button = std::size_t(event.code);
        down_[button] = event.down;
        pressed_[button] |= event.down;
      }
      set_modifiers(io, event.modifiers);
      [[fallthrough]];
    case Kind::move:
      io.MousePos = {float(event.place.x), float(event.place.y)};
      break;
    case Kind::wheel:
      io.MouseWheelH += float(event.place.x);
      io.MouseWheel += float(event.place.y);
      break;
    case Kind::key:
      for (const auto& [key, code] : key_map)
        if (code == event.code) set_key(io, key, event.down);
      set_modifiers(io, event.modifiers);
      break;
    case Kind::text:
      io.AddInputCharacter(static_cast<unsigned>(event.code));
      break;
    case Kind::scale:
      set_scale(event.place.x);
      // again, with the texture of the new font
      ImGui_ImplOpenGL3_Shutdown();
      ImGui_ImplOpenGL3_Init(glsl_version);
      break;
    default:  // the viewer's
      break;
  }
}

void Gui::begin_frame(const glm::ivec2& size, double seconds) {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {float(size.x), float(size.y)};
  io.DeltaTime = float(std::max(seconds, 1e-4));
  // A click that began and ended since the last frame shows for one frame.
  for (std::size_t i = 0; i < down_.size(); ++i) io.MouseDown[i] = down_[i] || pressed_[i];
  pressed_.fill(false);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
}

void Gui::end_frame() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  places_panels_ = false;
}

bool Gui::takes_pointer() const { return ImGui::GetIO().WantCaptureMouse; }
bool Gui::takes_keys() const { return ImGui::GetIO().WantTextInput; }
bool Gui::editing() const { return ImGui::IsAnyItemActive() || ImGui::IsMouseDown(0); }

void Messages::error(const std::string& text) {
  say(text);
  is_error_ = true;
  ++error_count_;
  print_notice(text);
}

void Messages::say(const std::string& text) {
  text_ = text;
  is_error_ = false;
  since_ = Clock::now();
  on_news_();
}

void Messages::attempt(const std::function<void()>& action) {
  try {
    action();
  } catch (...) {
    error(message_of(std::current_exception()));
  }
}

const std::string& Messages::shown() const {
  return Clock::now() - since_ > shown_for ? none_ : text_;
}

std::string message_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    return "out of memory; try --lod 1";
  } catch (const std::exception& e) {
    return e.what();
  }
}

}  // namespace psivox::view
