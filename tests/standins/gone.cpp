extern "C" int hapton_standin_is_gone() { return 1; }
