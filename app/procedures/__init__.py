"""Conversations with a module as generators: read, write, lock, change the baud rate …"""
