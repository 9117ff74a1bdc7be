int main_placeholder_rays;
