"""The page served with an editor: browsers on this machine choose, edit, save, run and watch models."""
