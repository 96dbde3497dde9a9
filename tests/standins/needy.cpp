extern "C" int hapton_standin_is_gone();
extern "C" unsigned hdInitDevice(const char*) { return static_cast<unsigned>(hapton_standin_is_gone()); }
